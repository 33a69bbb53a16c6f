import {
  Box3,
  BufferAttribute,
  BufferGeometry,
  Group,
  LineBasicMaterial,
  LineSegments,
  Matrix4,
  MeshStandardMaterial,
  SphereGeometry,
  Vector3,
} from "three";
import { couplings } from "./couplings";
import { paintEdges } from "./edges";
import { count, format } from "./element";
import { quarteredBall, triad } from "./glyphs";
import { ellipsoid, principalAxes } from "./inertia";
import { Instances, type Item } from "./instances";
import { KINDS } from "./joint_kinds";
import { matrixOf, placeOfJoint } from "./kinematics";
import { Labels } from "./labels";
import type { Layer, View } from "./layers";
import { loopLayers } from "./loops";
import { colors } from "./palette";
import { sidesOfSymbols } from "./processor";
import type { Joint, Scene, Shape } from "./scene";
import { shapeGroup } from "./shapes";
import { springs } from "./springs";

/** The layers of the bodies at rest, which need no motion. */
export function bodyLayers(view: View): Layer[] {
  return [
    shapes(view, "shapes", "Shapes", colors.bodies[0], true, (s) => s.role === "visual" && !s.stand_in),
    shapes(view, "stand-ins", "Stand-ins", colors.bodies[1], true, (s) => s.stand_in),
    springs(view),
    couplings(view),
    shapes(view, "collision", "Collision shapes", colors.collision, false, (s) => s.role === "collision"),
    ground(view),
    frames(view),
    names(view),
    joints(view),
    ...loopLayers(view),
    centres(view),
    ellipsoids(view),
  ].filter((layer) => layer !== null);
}

/** A layer of groups of instances. */
function fromInstances(view: View, layer: Omit<Layer, "root" | "update">, ...parts: Instances[]): Layer {
  const root = new Group();
  root.add(...parts);
  const update = () => {
    for (const part of parts) part.place(view.state.tree.poses, view.stage.unit * view.state.symbolScale);
  };
  return { ...layer, root, update };
}

function shapes(view: View, id: string, title: string, swatch: string, on: boolean, which: (shape: Shape) => boolean): Layer | null {
  const { scene, state, stage } = view;
  const chosen = scene.shapes.filter(which);
  if (chosen.length === 0) return null;
  const root = shapeGroup(scene, chosen, view.meshes);
  const parts = root.children.filter((part) => part instanceof Instances);
  let painted = -1;
  const update = () => {
    for (const part of parts) part.place(state.tree.poses, 1);
    if (!state.chosen || painted === state.selected || id === "collision") return;
    painted = state.selected;
    for (const part of parts) part.paint(painted, colors.chosen);
  };
  stage.bodies.add(root);
  const hint = () => (id === "stand-ins" ? "drawn where a body has no shape" : count(chosen.length, "shape"));
  return { id, title, hint, swatch, on, root, update, paint: ({ edge }) => paintEdges(edge) };
}

function ground({ stage }: View): Layer {
  return {
    id: "ground",
    title: "Ground",
    hint: () => `a line every ${format(stage.gridStep)} m`,
    swatch: "#8b98a6",
    on: true,
    root: stage.ground,
    update: () => {},
  };
}

/**
 * Where the axes of a body are drawn: at its origin if that is on the body, and else at its joint. The origin
 * of a body that is drawn in the construction frame may be metres away from it.
 */
export function placeOfFrame(scene: Scene, i: number): Vector3 {
  if (i === 0) return new Vector3();
  const { com, S_self } = scene.bodies[i];
  const joint = new Vector3(S_self[0], S_self[1], S_self[2]);
  const next = scene.bodies.slice(1).filter(({ predecessor }) => predecessor === i);
  const ends = scene.loops.flatMap((loop) => loop.ends.filter(({ body }) => body === i));
  const named = scene.frames.filter(({ body }) => body === i);
  const poses = [...next.map(({ S_prev }) => S_prev), ...ends.map(({ pose }) => pose), ...named.map(({ pose }) => pose)];
  const box = new Box3().setFromPoints([joint, new Vector3(...com), ...poses.map(([x, y, z]) => new Vector3(x, y, z))]);
  const size = box.getSize(new Vector3()).length();
  return box.distanceToPoint(new Vector3()) > 0.1 * size ? joint : new Vector3();
}

function frames(view: View): Layer {
  const { scene } = view;
  const items: Item[] = [
    ...scene.bodies.map((_, body) => ({ body, pose: new Matrix4().setPosition(placeOfFrame(scene, body)), symbol: true })),
    ...scene.frames.map((frame) => ({ body: frame.body, pose: matrixOf(frame.pose), symbol: true })),
  ];
  const material = new MeshStandardMaterial({ vertexColors: true, roughness: 0.6 });
  return fromInstances(
    view,
    {
      id: "frames",
      title: "Frames",
      hint: () => "of the ground, of bodies (at their joints if their origins are elsewhere), and named ones; x red, y green, z blue",
      swatch: colors.y,
      on: false,
      over: true,
    },
    new Instances(triad(sidesOfSymbols(items.length)), material, items),
  );
}

function names({ scene, state, stage }: View): Layer {
  const labels = new Labels([
    ...scene.bodies.map(({ name, com }, body) => ({ text: name, body, at: new Vector3(...(com ?? [0, 0, 0])) })),
    ...scene.frames.map(({ name, body, pose }) => ({ text: name, body, at: new Vector3(...pose.slice(0, 3)) })),
  ]);
  return {
    id: "names",
    title: "Names",
    hint: () => "of bodies at their centres of mass, of frames at their origins; what would lie on another is left out",
    swatch: "#8b98a6",
    on: false,
    over: true,
    root: labels,
    update: () => labels.place(state.tree.poses, stage),
    paint: (palette) => labels.paint(palette),
  };
}

/**
 * The lead with which a helical joint is drawn: its own if that can be seen, or else the nearest one that
 * can.
 */
function drawnLead(pitch: number, unit: number): number {
  const lead = (2 * Math.PI * pitch) / unit;
  return Math.sign(lead || 1) * Math.min(1.5, Math.max(0.22, Math.abs(lead)));
}

function joints(view: View): Layer | null {
  const { scene, stage } = view;
  const symbols = new Map<string, { make: (sides: number, lead: number) => BufferGeometry; lead: number; items: Item[] }>();
  const color = (joint: Joint) => (joint.leader ? colors.coupled : joint.passive ? colors.passive : colors.driven);
  scene.bodies.slice(1).forEach((body, k) => {
    const { joint } = body;
    const { symbol: make, hasPitch } = KINDS[joint.kind];
    if (!make) return;
    const pose = matrixOf(body.S_self).setPosition(placeOfJoint(body));
    const lead = hasPitch ? drawnLead(joint.pitch, stage.unit) : 0;
    const key = `${joint.kind} ${lead}`;
    const symbol = symbols.get(key) ?? { make, lead, items: [] };
    symbols.set(key, symbol);
    symbol.items.push({ body: k + 1, pose, color: color(joint), symbol: true });
  });
  if (symbols.size === 0) return null;
  const material = new MeshStandardMaterial({ roughness: 0.5 });
  return fromInstances(
    view,
    {
      id: "joints",
      title: "Joint axes",
      hint: () => "ring: hinge, rail: slider, thread: screw; grey passive, violet coupled",
      swatch: colors.driven,
      on: false,
      over: true,
    },
    ...[...symbols.values()].map(({ make, lead, items }) => new Instances(make(sidesOfSymbols(items.length), lead), material, items)),
  );
}

function centres(view: View): Layer | null {
  const { scene, state, stage } = view;
  const heavy = scene.bodies.map((body, i) => ({ body, i })).filter(({ body, i }) => i > 0 && body.mass > 0);
  if (heavy.length === 0) return null;
  const most = Math.max(...heavy.map(({ body }) => body.mass));
  const material = new MeshStandardMaterial({ vertexColors: true, roughness: 0.4 });
  const own = new Instances(
    quarteredBall(sidesOfSymbols(heavy.length)),
    material,
    heavy.map(({ body, i }) => {
      const size = 0.12 + 0.16 * Math.cbrt(body.mass / most);
      return { body: i, pose: new Matrix4().makeScale(size, size, size).setPosition(...body.com), symbol: true };
    }),
  );
  const whole = new Instances(
    new SphereGeometry(0.4, 32, 20),
    new MeshStandardMaterial({ color: colors.whole, transparent: true, opacity: 0.75, depthWrite: false }),
    [{ body: 0, pose: new Matrix4(), symbol: true }],
  );
  const plumb = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: colors.whole }));
  plumb.frustumCulled = false;
  const root = new Group();
  root.add(own, whole, plumb);
  let com: Vector3 | null = null;
  const update = () => {
    com = state.centreOfMass().com;
    whole.items[0].pose.setPosition(com);
    for (const part of [own, whole]) part.place(state.tree.poses, stage.unit * state.symbolScale);
    const points = new Float32Array([...com.toArray(), ...stage.below(com).toArray()]);
    plumb.geometry.dispose();
    plumb.geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(points, 3));
  };
  return {
    id: "com",
    title: "Centres of mass",
    hint: () => `of bodies, and of the whole (green)${com ? `: (${com.toArray().map(format).join(", ")}) m` : ""}`,
    swatch: colors.whole,
    on: false,
    over: true,
    root,
    update,
  };
}

function ellipsoids(view: View): Layer | null {
  const items: Item[] = [];
  view.scene.bodies.forEach((body, i) => {
    if (i === 0 || !(body.mass > 0)) return;
    const { moments, axes } = principalAxes(body.inertia);
    const semiAxes = ellipsoid(body.mass, moments);
    if (semiAxes.length() === 0) return;
    const least = 0.02 * semiAxes.length(); // what is a disc or a needle keeps a thickness
    items.push({ body: i, pose: axes.setPosition(...body.com).scale(semiAxes.clampScalar(least, Infinity)) });
  });
  if (items.length === 0) return null;
  const sides = 0.8 * sidesOfSymbols(items.length);
  const material = new MeshStandardMaterial({ color: colors.ellipsoid, transparent: true, opacity: 0.42, depthWrite: false, roughness: 0.35 });
  return fromInstances(
    view,
    { id: "ellipsoids", title: "Inertia ellipsoids", hint: () => "homogeneous ones of the same mass and inertia", swatch: colors.ellipsoid, on: false },
    new Instances(new SphereGeometry(1, sides, sides / 1.6), material, items),
  );
}

