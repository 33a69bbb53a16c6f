import { Group, Vector3 } from "three";
import { Arrows } from "./arrows";
import { placeOfFrame } from "./body_layers";
import { format } from "./element";
import { matrixOf, placeOfJoint } from "./kinematics";
import type { Layer, View } from "./layers";
import { colors } from "./palette";
import { scaleOf, toArrow, type Scale } from "./scale";
import type { Vec3 } from "./scene";
import { screwOf, twistAbout, wrenchAbout, type Screw } from "./screws";

/** Something that has a screw in a motion, and the point of a body at which the arrows of the screw stand. */
interface Bearer {
  body: number;
  point: Vector3;
  /** Its spatial screw at a sample of the motion. */
  at: (sample: number) => readonly number[];
  /** Its spatial screw at the shown time. */
  now: () => Screw | null;
}

interface Kind {
  id: string;
  title: string;
  colors: readonly [string, string];
  units: readonly [string, string];
  /** Whether it is a wrench or momentum and not a twist. */
  dual: boolean;
  where: string;
  bearers: Bearer[];
  /** The bearers whose arrows are drawn now. */
  drawn: () => Bearer[];
  /** All bearers whose arrows have the same scale. */
  scaledWith?: Bearer[];
  /** Whether it is shown at first. */
  on?: boolean;
}

/** The length of the longest arrow in a motion, in units of symbols. */
const LONGEST = 4.5;

/** What the longest arrow stands for. */
function said({ most, clips }: Scale, unit: string): string {
  return `${format(most)} ${unit}${clips ? " and more" : ""}`;
}

/** The layers of twists, wrenches of joints and loops, loads, forces of springs, and momenta. */
export function vectorLayers(view: View): Layer[] {
  const { scene, state } = view;
  const motion = scene.motion!;
  const centre = (i: number) => new Vector3(...scene.bodies[i].com);
  const ofBodies = (kind: "twists" | "wrenches" | "momenta", point: (i: number) => Vector3): Bearer[] => {
    const samples = motion[kind];
    if (!samples) return [];
    return scene.bodies.slice(1).map((_, k) => ({ body: k + 1, point: point(k + 1), at: (sample) => samples[sample][k], now: () => state.screw(kind, k + 1) }));
  };
  const chosen = (bearers: Bearer[]) => () => (state.everyBody ? bearers : bearers.filter(({ body }) => body === state.selected));
  const joint = (i: number) => placeOfJoint(scene.bodies[i]);
  const twists = ofBodies("twists", centre);
  const wrenches = ofBodies("wrenches", joint);
  const momenta = ofBodies("momenta", centre);
  const ofLoops = loopBearers(view);
  const forces = [...wrenches, ...ofLoops];
  const loads = loadBearers(view);
  const wrench = { units: ["N m", "N"], dual: true, colors: colors.wrenches } as const;
  return [
    layer(view, { id: "twists", title: "Twists", units: ["rad/s", "m/s"], dual: false, colors: colors.twists, where: "at the centre of mass", bearers: twists, drawn: chosen(twists) }),
    layer(view, { ...wrench, id: "wrenches", title: "Wrenches of joints", where: "at the joint", bearers: wrenches, drawn: chosen(wrenches), scaledWith: forces }),
    layer(view, { ...wrench, id: "loop-wrenches", title: "Wrenches of loops", where: "at the loop joint, on its second body", bearers: ofLoops, drawn: () => ofLoops, scaledWith: forces }),
    layer(view, { ...wrench, id: "loads", title: "Loads", where: "at the frame on which it acts, or at the joint of a body whose origin is not on it", bearers: loads, drawn: () => loads, on: true }),
    springForces(view),
    layer(view, { id: "momenta", title: "Momenta", units: ["N m s", "N s"], dual: true, colors: colors.momenta, where: "at the centre of mass", bearers: momenta, drawn: chosen(momenta) }),
  ].filter((made) => made !== null);
}

function loopBearers({ scene, state }: View): Bearer[] {
  const samples = scene.motion?.loop_wrenches;
  if (!samples) return [];
  return scene.loops.map(({ ends: [, end] }, k) => ({
    body: end.body,
    point: new Vector3().setFromMatrixPosition(matrixOf(end.pose)),
    at: (sample) => samples[sample][k],
    now: () => state.loopWrench(k),
  }));
}

function loadBearers({ scene, state }: View): Bearer[] {
  const { load_frames: frames, loads: samples } = scene.motion!;
  if (!frames || !samples) return [];
  const place = (name: string, body: number, point: Vec3) => (scene.bodies[body].name === name ? placeOfFrame(scene, body) : new Vector3(...point));
  return frames.map(({ name, body, point }, k) => ({ body, point: place(name, body, point), at: (sample) => samples[sample][k], now: () => state.load(k) }));
}

/** Moments up to this part of the forces, and forces up to this part of the moments, have no arrows. */
const NEGLIGIBLE = 1e-5;

function layer(view: View, kind: Kind): Layer | null {
  const { state, stage, history } = view;
  const { bearers, dual, units } = kind;
  if (bearers.length === 0) return null;
  const [first, second] = [new Arrows(bearers.length, kind.colors[0], true), new Arrows(bearers.length, kind.colors[1], false)];
  const root = new Group();
  root.add(first, second);
  const about = (spatial: Screw, point: Vector3) => (state.representation === "spatial" ? spatial : dual ? wrenchAbout(spatial, point) : twistAbout(spatial, point));

  const known = new Map<boolean, [Scale, Scale]>();
  const found = (): [Scale, Scale] => {
    const largest = history.indices.map((index, k) => {
      const most = [0, 0];
      for (const { body, point, at } of kind.scaledWith ?? bearers) {
        const { w, v } = about(screwOf(at(index)), point.clone().applyMatrix4(history.poses[k][body]));
        most[0] = Math.max(most[0], w.length());
        most[1] = Math.max(most[1], v.length());
      }
      return most;
    });
    const [w, v] = [0, 1].map((k) => scaleOf(largest.map((most) => most[k])));
    const size = stage.radius;
    if (w.most < NEGLIGIBLE * size * v.most) w.most = 0;
    if (v.most * size < NEGLIGIBLE * w.most) v.most = 0;
    return [w, v];
  };
  const scalesNow = (): [Scale, Scale] => {
    const spatial = state.representation === "spatial";
    if (!known.has(spatial)) known.set(spatial, found());
    return known.get(spatial)!;
  };

  const long = () => LONGEST * stage.unit * state.arrowScale;
  let hint = "";
  const update = () => {
    const scaled = scalesNow();
    const [w, v]: { from: Vector3; vector: Vector3 }[][] = [[], []];
    for (const { body, point, now } of kind.drawn()) {
      const spatial = now();
      if (!spatial) continue;
      const at = point.clone().applyMatrix4(state.tree.poses[body]);
      const screw = about(spatial, at);
      const from = state.representation === "spatial" ? new Vector3() : at;
      if (scaled[0].most > 0) w.push({ from, vector: toArrow(screw.w, scaled[0], long()) });
      if (scaled[1].most > 0) v.push({ from, vector: toArrow(screw.v, scaled[1], long()) });
    }
    first.show(w, stage.unit * state.symbolScale);
    second.show(v, stage.unit * state.symbolScale);
    const where = state.representation === "spatial" ? "about the inertial origin" : kind.where;
    hint = state.moment ? `${where}; longest ${said(scaled[0], units[0])} (two heads), ${said(scaled[1], units[1])}` : "play or scrub: this pose is not of the motion";
  };
  const scales = () => {
    return scalesNow()
      .map(({ most, clips }, k) => ({ color: kind.colors[k], heads: 2 - k, unit: units[k], each: most / long(), clips }))
      .filter(({ each }) => each > 0);
  };
  return { id: kind.id, title: kind.title, hint: () => hint, swatch: kind.colors[0], on: kind.on ?? false, over: true, root, update, scales };
}

/** The forces of springs and dampers on the bodies at both of their ends. */
function springForces({ scene, state, stage }: View): Layer | null {
  const lines = scene.lines ?? [];
  const tensions = scene.motion?.tensions;
  if (!tensions || lines.length === 0) return null;
  const arrows = new Arrows(2 * lines.length, colors.spring, false);
  const root = new Group();
  root.add(arrows);
  const scale = scaleOf(tensions.map((row) => row.reduce((x, tension) => Math.max(x, Math.abs(tension)), 0)));
  const long = () => LONGEST * stage.unit * state.arrowScale;
  const update = () => {
    const vectors = lines.flatMap(({ ends }, k) => {
      const tension = state.tension(k);
      const [a, b] = ends.map(({ body, point }) => new Vector3(...point).applyMatrix4(state.tree.poses[body]));
      if (!tension || scale.most === 0) return [];
      const pull = toArrow(b.clone().sub(a).setLength(tension), scale, long());
      return [{ from: a, vector: pull }, { from: b, vector: pull.clone().negate() }];
    });
    arrows.show(vectors, stage.unit * state.symbolScale);
  };
  const scales = () => (scale.most > 0 ? [{ color: colors.spring, heads: 1, unit: "N", each: scale.most / long(), clips: scale.clips }] : []);
  return { id: "spring-forces", title: "Forces of springs", hint: () => `on the bodies at their ends; longest ${said(scale, "N")}`, swatch: colors.spring, on: false, over: true, root, update, scales };
}
