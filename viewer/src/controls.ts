import { Vector3 } from "three";
import { byId, element } from "./element";
import type { Player } from "./player";
import type { Scene } from "./scene";
import { listen, type Shortcut } from "./shortcuts";
import type { Stage } from "./stage";
import type { State } from "./state";

/** How far the joints and named frames on a body are from its centre of mass, m. */
function reachOf({ bodies, frames }: Scene, i: number): number {
  const com = new Vector3(...(bodies[i].com ?? [0, 0, 0]));
  const own = i > 0 ? [bodies[i].S_self] : [];
  const next = bodies.slice(1).filter(({ predecessor }) => predecessor === i).map(({ S_prev }) => S_prev);
  const named = frames.filter(({ body }) => body === i).map(({ pose }) => pose);
  return Math.max(0, ...[...own, ...next, ...named].map(([x, y, z]) => com.distanceTo(new Vector3(x, y, z))));
}

/** Keys and buttons of the page, and clicks into the view. */
export function control(state: State, stage: Stage, player: Player | null, showTab: (id: string, focus: boolean) => void, changeTheme: () => void): void {
  const { scene } = state;
  const savePng = async () => {
    const link = element("a", { href: URL.createObjectURL(await stage.png()), download: `${scene.name}.png` });
    link.click();
    window.setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  };
  const centre = () => new Vector3(...(scene.bodies[state.selected].com ?? [0, 0, 0])).applyMatrix4(state.tree.poses[state.selected]);
  let following = false;
  const follow = (on: boolean) => {
    following = on;
    byId("follow").setAttribute("aria-pressed", String(on));
    if (on) stage.fitBall(centre(), Math.max(reachOf(scene, state.selected), 2 * stage.unit));
    stage.follow(on ? centre : null);
  };
  const fit = (direction?: readonly number[]) => {
    if (following) follow(false);
    stage.fit(direction);
  };
  let followed = state.selected;
  state.onChange(() => {
    if (followed === state.selected) return;
    followed = state.selected;
    if (following) stage.follow(centre);
  });
  const help = byId<HTMLDialogElement>("help");
  const turn = Math.PI / 24;
  const shortcuts: (Shortcut | false)[] = [
    player !== null && { key: " ", shown: "space", does: "play or pause", run: () => player.toggle() },
    player !== null && { key: "ArrowLeft", shown: "←", does: "one sample back", run: () => player.step(-1) },
    player !== null && { key: "ArrowRight", shown: "→", does: "one sample on", run: () => player.step(1) },
    player !== null && { key: "Home", shown: "Home", does: "to the start", run: () => player.toEnd(false) },
    player !== null && { key: "End", shown: "End", does: "to the end", run: () => player.toEnd(true) },
    { key: "f", shown: "f", does: "fit everything into the view", run: () => fit() },
    { key: "c", shown: "c", does: "fit the chosen body into the view and follow it", run: () => follow(!following) },
    { key: "1", shown: "1", does: "look along -x", run: () => fit([1, 0, 0]) },
    { key: "2", shown: "2", does: "look along y", run: () => fit([0, -1, 0]) },
    { key: "3", shown: "3", does: "look along -z", run: () => fit([0, 0, 1]) },
    { key: "Shift+ArrowLeft", shown: "shift ←", does: "turn the view to the left", run: () => stage.orbit(-turn, 0) },
    { key: "Shift+ArrowRight", shown: "shift →", does: "turn the view to the right", run: () => stage.orbit(turn, 0) },
    { key: "Shift+ArrowUp", shown: "shift ↑", does: "look from higher", run: () => stage.orbit(0, turn) },
    { key: "Shift+ArrowDown", shown: "shift ↓", does: "look from lower", run: () => stage.orbit(0, -turn) },
    { key: "+", shown: "+", does: "nearer", run: () => stage.orbit(0, 0, 1.15) },
    { key: "-", shown: "−", does: "farther", run: () => stage.orbit(0, 0, 1 / 1.15) },
    { key: "j", shown: "j", does: "joints", run: () => showTab("joints", true) },
    { key: "l", shown: "l", does: "layers", run: () => showTab("layers", true) },
    { key: "b", shown: "b", does: "numbers of the chosen body", run: () => showTab("body", true) },
    { key: "n", shown: "n", does: "choose the next body", run: () => state.select((state.selected + 1) % scene.bodies.length) },
    { key: "d", shown: "d", does: "dark or light", run: () => changeTheme() },
    { key: "s", shown: "s", does: "save a PNG", run: () => void savePng() },
    { key: "?", shown: "?", does: "these keys", run: () => help.showModal() },
  ];
  listen(shortcuts.filter((shortcut) => shortcut !== false));
  byId("png").addEventListener("click", () => void savePng());
  byId("theme").addEventListener("click", () => changeTheme());
  byId("help-button").addEventListener("click", () => help.showModal());
  byId("fit").addEventListener("click", () => fit());
  byId("follow").addEventListener("click", () => follow(!following));
  byId("view-x").addEventListener("click", () => fit([1, 0, 0]));
  byId("view-y").addEventListener("click", () => fit([0, -1, 0]));
  byId("view-z").addEventListener("click", () => fit([0, 0, 1]));

  // A click, not a drag, chooses a body.
  let pressed = { x: 0, y: 0 };
  stage.canvas.addEventListener("pointerdown", (event) => (pressed = { x: event.offsetX, y: event.offsetY }));
  stage.canvas.addEventListener("pointerup", (event) => {
    if (event.button !== 0 || Math.hypot(event.offsetX - pressed.x, event.offsetY - pressed.y) > 4) return;
    const body = stage.pick(event.offsetX, event.offsetY);
    if (body !== null) state.select(body);
  });
}
