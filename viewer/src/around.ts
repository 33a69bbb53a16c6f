import type { Layer } from "./layers";
import type { Player } from "./player";
import type { Stage } from "./stage";
import type { State } from "./state";

declare global {
  interface Window {
    /**
     * Functions for programs around the page, and for tests. Poses are 4 × 4 matrices, column by column; the
     * gap is the largest residual of the loops, with lengths in units of the size of the mechanism.
     */
    axode: {
      setState: (q: number[]) => void;
      setTime: (t: number) => void;
      time: () => number;
      select: (body: string) => void;
      poses: () => Record<string, number[]>;
      gap: () => number;
      layers: () => Record<string, boolean>;
      setLayer: (id: string, on: boolean) => void;
      orbit: (around: number, above: number, zoom?: number) => void;
      png: () => Promise<Blob>;
      frames: () => number;
    };
  }
}

/**
 * Lets programs around the page send states: by calls, by messages, and by the stream that the scene names.
 */
export function listenAround(state: State, stage: Stage, player: Player | null, layers: readonly Layer[], setLayer: (id: string, on: boolean) => void): void {
  const { scene } = state;
  window.axode = {
    setState: (q) => state.setCoordinates(q),
    setTime: (t) => player?.seek(t),
    time: () => state.t,
    select: (name) => {
      const index = scene.bodies.findIndex((body) => body.name === name);
      if (index < 0) throw new Error(`There is no body "${name}".`);
      state.select(index);
    },
    poses: () => Object.fromEntries(scene.bodies.map((body, i) => [body.name, state.tree.poses[i].toArray()])),
    gap: () => state.closure.gap(state.q),
    layers: () => Object.fromEntries(layers.map(({ id, on }) => [id, on])),
    setLayer,
    orbit: (around, above, zoom) => stage.orbit(around, above, zoom),
    png: () => stage.png(),
    frames: () => stage.frameCount,
  };
  const take = (q: unknown) => {
    if (Array.isArray(q) && q.length === scene.nq && q.every(Number.isFinite)) state.setCoordinates(q as number[]);
  };
  window.addEventListener("message", ({ data }) => take(data?.axode?.q));
  if (scene.live?.startsWith("http://127.0.0.1:")) {
    new EventSource(scene.live).addEventListener("message", ({ data }) => take(JSON.parse(data)?.q));
  }
}
