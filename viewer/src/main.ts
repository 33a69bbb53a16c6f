import "./page.css";
import { fillBodyPanel } from "./body_panel";
import { byId, element } from "./element";
import { History } from "./history";
import { fillJointPanel } from "./joint_panel";
import { fillLayerPanel } from "./layer_panel";
import { makeLayers } from "./layers";
import { readMeshes } from "./meshes";
import { palettes } from "./palette";
import { Player } from "./player";
import { Plots } from "./plots";
import { readScene, type Scene } from "./scene";
import { reach } from "./shapes";
import { listen, type Shortcut } from "./shortcuts";
import { Stage } from "./stage";
import { State } from "./state";
import { makeTabs } from "./tabs";

function count(n: number, what: string, many = `${what}s`): string {
  return `${n} ${n === 1 ? what : many}`;
}

async function show(scene: Scene): Promise<void> {
  const { motion } = scene;
  document.title = `${scene.name} - axode`;
  byId("title").textContent = scene.name;
  byId("summary").textContent = [
    count(scene.bodies.length - 1, "body", "bodies"),
    `nq = ${scene.nq}, nv = ${scene.nv}`,
    scene.loops.length > 0 ? count(scene.loops.length, "loop") : "",
    motion ? `motion of ${count(motion.t.length, "sample")}` : "",
  ].filter(Boolean).join(" · ");

  const warnings = [...scene.warnings];
  const warningList = element("ul");
  byId("warnings").append(warningList);
  const showWarnings = () => {
    warningList.replaceChildren(...warnings.map((text) => element("li", {}, text)));
    byId("tab-warnings").textContent = `Warnings (${warnings.length})`;
    byId("tab-warnings").hidden = warnings.length === 0;
  };
  let write = () => {};
  const showTab = makeTabs({ joints: "Joints", layers: "Layers", body: "Body", warnings: "Warnings" }, () => write());
  const meshes = await readMeshes(scene.meshes, (text) => {
    if (!warnings.includes(text)) warnings.push(text);
    showWarnings();
  });
  showWarnings();

  const state = new State(scene);
  const canvas = byId<HTMLCanvasElement>("canvas");
  canvas.setAttribute("aria-label", `View of ${scene.name}: ${count(scene.bodies.length - 1, "moving body", "moving bodies")}`);
  const stage = new Stage(canvas, scene.gravity);
  const history = new History(scene);
  const now = reach(scene, state.tree.poses, meshes);
  const every = Math.ceil(history.indices.length / 24);
  const ever = history.indices.filter((_, k) => k % every === 0).flatMap((_, k) => reach(scene, history.poses[k * every], meshes));
  stage.measure(now, [...now, ...ever]);

  const layers = makeLayers({ scene, state, stage, history, meshes });
  for (const layer of layers) {
    if (!layer.root.parent) (layer.over ? stage.over : stage.space).add(layer.root);
    layer.root.visible = layer.on;
  }
  const setLayer = (id: string, on: boolean) => {
    const layer = layers.find((candidate) => candidate.id === id);
    if (!layer) throw new Error(`There is no layer "${id}"; there are ${layers.map((l) => l.id).join(", ")}.`);
    layer.on = on;
    layer.root.visible = on;
    state.changed();
  };

  const showJoints = fillJointPanel(byId("joints"), state, 2 * stage.radius);
  const showLayers = fillLayerPanel(byId("layers"), layers, state, setLayer);
  const showBody = fillBodyPanel(byId("body"), state);

  // Numbers are written a few times a second, bodies are drawn at every frame.
  let written = 0;
  write = () => {
    written = 0;
    showLayers();
    if (!byId("joints").hidden) showJoints();
    if (!byId("body").hidden) showBody();
    byId("note").textContent = motion && !state.moment ? "Posed by hand: play or scrub to go back to the motion." : "";
  };
  stage.beforeFrame = () => {
    for (const layer of layers) if (layer.on) layer.update();
    written ||= window.setTimeout(() => write(), player?.playing ? 120 : 0);
  };
  state.onChange(() => stage.invalidate(true));

  let player: Player | null = null;
  let plots: Plots | null = null;
  if (motion) {
    byId("time").hidden = false;
    player = new Player(byId("player"), state);
    plots = new Plots(byId("plots"), state, (t) => player!.seek(t));
  }

  let dark = false;
  const setTheme = (toDark: boolean) => {
    dark = toDark;
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    byId("theme").setAttribute("aria-pressed", String(dark));
    stage.setTheme(dark);
    for (const layer of layers) layer.paint?.(palettes[dark ? "dark" : "light"]);
    plots?.repaint();
    stage.invalidate(true);
  };
  const preference = window.matchMedia("(prefers-color-scheme: dark)");
  preference.addEventListener("change", () => setTheme(preference.matches));
  setTheme(preference.matches);

  const savePng = async () => {
    const link = element("a", { href: URL.createObjectURL(await stage.png()), download: `${scene.name}.png` });
    link.click();
    window.setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  };
  const help = byId<HTMLDialogElement>("help");
  const turn = Math.PI / 24;
  const shortcuts: (Shortcut | false)[] = [
    motion !== null && { key: " ", shown: "space", does: "play or pause", run: () => player!.toggle() },
    motion !== null && { key: "ArrowLeft", shown: "←", does: "one sample back", run: () => player!.step(-1) },
    motion !== null && { key: "ArrowRight", shown: "→", does: "one sample on", run: () => player!.step(1) },
    motion !== null && { key: "Home", shown: "Home", does: "to the start", run: () => player!.toEnd(false) },
    motion !== null && { key: "End", shown: "End", does: "to the end", run: () => player!.toEnd(true) },
    { key: "f", shown: "f", does: "fit everything into the view", run: () => stage.fit() },
    { key: "1", shown: "1", does: "look along -x", run: () => stage.fit([1, 0, 0]) },
    { key: "2", shown: "2", does: "look along y", run: () => stage.fit([0, -1, 0]) },
    { key: "3", shown: "3", does: "look from above", run: () => stage.fit([0, -1e-3, 1]) },
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
    { key: "d", shown: "d", does: "dark or light", run: () => setTheme(!dark) },
    { key: "s", shown: "s", does: "save a PNG", run: () => void savePng() },
    { key: "?", shown: "?", does: "these keys", run: () => help.showModal() },
  ];
  listen(shortcuts.filter((shortcut) => shortcut !== false));
  byId("png").addEventListener("click", () => void savePng());
  byId("theme").addEventListener("click", () => setTheme(!dark));
  byId("help-button").addEventListener("click", () => help.showModal());
  byId("fit").addEventListener("click", () => stage.fit());
  byId("view-x").addEventListener("click", () => stage.fit([1, 0, 0]));
  byId("view-y").addEventListener("click", () => stage.fit([0, -1, 0]));
  byId("view-z").addEventListener("click", () => stage.fit([0, -1e-3, 1]));

  // A click, not a drag, chooses a body.
  let pressed = { x: 0, y: 0 };
  canvas.addEventListener("pointerdown", (event) => (pressed = { x: event.offsetX, y: event.offsetY }));
  canvas.addEventListener("pointerup", (event) => {
    if (event.button !== 0 || Math.hypot(event.offsetX - pressed.x, event.offsetY - pressed.y) > 4) return;
    const body = stage.pick(event.offsetX, event.offsetY);
    if (body !== null) state.select(body);
  });

  window.axode = {
    setState: (q) => state.setCoordinates(q),
    setTime: (t) => player?.seek(t),
    time: () => state.t,
    select: (name) => state.select(scene.bodies.findIndex((body) => body.name === name)),
    poses: () => Object.fromEntries(scene.bodies.map((body, i) => [body.name, state.tree.poses[i].toArray()])),
    layers: () => Object.fromEntries(layers.map(({ id, on }) => [id, on])),
    setLayer,
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
  stage.fit([1.25, -1.6, 0.75]);
  canvas.dataset.ready = "true";
}

declare global {
  interface Window {
    /** For programs around the page, and tests. Poses are 4 × 4 matrices, column by column. */
    axode: {
      setState: (q: number[]) => void;
      setTime: (t: number) => void;
      time: () => number;
      select: (body: string) => void;
      poses: () => Record<string, number[]>;
      layers: () => Record<string, boolean>;
      setLayer: (id: string, on: boolean) => void;
      png: () => Promise<Blob>;
      frames: () => number;
    };
  }
}

try {
  await show(readScene(byId("scene").textContent ?? "null"));
} catch (error) {
  byId("title").textContent = "axode";
  document.querySelector("main")!.replaceChildren(element("p", { class: "failure", role: "alert" }, (error as Error).message));
}
