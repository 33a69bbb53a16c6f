import "./page.css";
import { listenAround } from "./around";
import { fillBodyPanel } from "./body_panel";
import { control } from "./controls";
import { byId, count, element } from "./element";
import { History } from "./history";
import { fillJointPanel } from "./joint_panel";
import { fillLayerPanel } from "./layer_panel";
import { fillLegend } from "./legend";
import { makeLayers } from "./layers";
import { planeNormal } from "./kinematics";
import { readMeshes } from "./meshes";
import { palettes } from "./palette";
import { Player } from "./player";
import { Plots } from "./plots";
import { readScene, type Scene } from "./scene";
import { reach } from "./shapes";
import { Stage } from "./stage";
import { State } from "./state";
import { makeTabs } from "./tabs";
import { fillWarnings } from "./warnings";

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

  let write = () => {};
  const showTab = makeTabs({ joints: "Joints", layers: "Layers", body: "Body", warnings: "Warnings" }, () => write());
  const meshes = await readMeshes(scene.meshes, fillWarnings(byId("warnings"), scene.warnings));

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
  const showLegend = fillLegend(byId("legend"), layers, stage);

  // Numbers are written a few times a second, bodies are drawn at every frame.
  let written = 0;
  write = () => {
    written = 0;
    showLayers();
    showLegend();
    if (!byId("joints").hidden) showJoints();
    if (!byId("body").hidden) showBody();
    const posed = motion && !state.moment ? "Posed by hand: play or scrub to go back to the motion." : "";
    byId("note").textContent = [state.notice, posed].filter(Boolean).join(" ");
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

  control(state, stage, player, showTab, () => setTheme(!dark));
  listenAround(state, stage, player, layers, setLayer);
  const normal = planeNormal(scene, state.tree.poses);
  stage.fit(normal ? stage.before(normal).toArray() : undefined);
  canvas.dataset.ready = "true";
}

try {
  await show(readScene(byId("scene").textContent ?? "null"));
} catch (error) {
  byId("title").textContent = "axode";
  document.querySelector("main")!.replaceChildren(element("p", { class: "failure", role: "alert" }, (error as Error).message));
}
