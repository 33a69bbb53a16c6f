import type { JointKind } from "./joint_kinds";

/** The scene that a page is given: one JSON object, described in viewer/README.md. */

/** Position and quaternion: x y z, qx qy qz qw. */
export type Pose = [number, number, number, number, number, number, number];
export type Vec3 = [number, number, number];

export interface Joint {
  name: string;
  kind: JointKind;
  pitch: number;
  iq: number;
  nq: number;
  iv: number;
  nv: number;
  leader: { joint: number; ratio: number; offset: number } | null;
  limits: [number | null, number | null][];
  passive: boolean;
}

export interface Body {
  name: string;
  predecessor: number;
  S_prev: Pose;
  S_self: Pose;
  A: Pose;
  mass: number;
  com: Vec3;
  inertia: [number, number, number, number, number, number];
  joint: Joint;
}

export interface NamedFrame {
  name: string;
  body: number;
  pose: Pose;
}

export interface Shape {
  body: number;
  pose: Pose;
  role: "visual" | "collision";
  name: string;
  kind: "box" | "sphere" | "cylinder" | "capsule" | "ellipsoid" | "mesh" | "hull" | "plane" | "thread" | "socket";
  size: Vec3;
  radius: number;
  length: number;
  scale: Vec3;
  mesh: number;
  /** How far a thread advances in a turn, m. */
  lead: number;
  /** Points of a hull, which is the convex hull of balls of this radius about these points. */
  points: Vec3[];
  color: [number, number, number, number] | null;
  stand_in: boolean;
}

export interface MeshFile {
  file: string;
  format: "stl" | "obj" | "dae" | "glb" | "gltf";
  data: string;
}

export interface Loop {
  name: string;
  kind: string;
  ends: [{ body: number; pose: Pose }, { body: number; pose: Pose }];
  /** Of a helical joint, m/rad. */
  pitch?: number;
  /**
   * Length of a rod or radius of what rolls, m; of a
   * universal joint the cosine of the angle between its axes.
   */
  size?: number;
  /** Whether a wheel rolls and not a sphere. */
  wheel?: boolean;
}

/** Σ factor q[coordinate] = offset */
export interface Coupling {
  name: string;
  terms: [coordinate: number, factor: number][];
  offset: number;
}

/** A spring, a damper or a drive between two points. */
export interface Line {
  ends: [{ body: number; point: Vec3 }, { body: number; point: Vec3 }];
  stiffness: number;
  rest: number;
  damping: number;
  driven: boolean;
}

export interface Series {
  name: string;
  unit: string;
  labels: string[];
  values: number[][];
}

export interface Motion {
  t: number[];
  q: number[][];
  v: number[][];
  tau: number[][] | null;
  series: Series[];
  /** Spatial twists, angular part first: for each sample and then for each body from body 1 on. */
  twists: number[][][] | null;
  wrenches: number[][][] | null;
  momenta: number[][][] | null;
  contact_shapes: string[];
  /** For each sample a list of points of contact, each of them 17 numbers, see contact_layers.ts. */
  contacts: number[][][] | null;
  /**
   * Spatial wrenches of the loop joints on their second bodies: for each sample and then for each loop joint.
   */
  loop_wrenches?: number[][][] | null;
  /** The frames on which loads act, each as a point of a body. */
  load_frames?: { name: string; body: number; point: Vec3 }[];
  /** Spatial wrenches of the loads: for each sample and then for each of the frames. */
  loads?: number[][][] | null;
  /** Tensions of the lines, N: for each sample and then for each line. */
  tensions?: number[][] | null;
}

export interface Scene {
  format: string;
  name: string;
  gravity: Vec3;
  nq: number;
  nv: number;
  /** bodies[0] is the ground, which has a name only. */
  bodies: Body[];
  frames: NamedFrame[];
  shapes: Shape[];
  meshes: MeshFile[];
  loops: Loop[];
  couplings?: Coupling[];
  lines?: Line[];
  q: number[];
  warnings: string[];
  /** The address from which states come while a program runs. */
  live?: string;
  motion: Motion | null;
  coordinate_names: string[];
  velocity_names: string[];
}

const FORMAT = "axode scene 1";

function fail(what: string): never {
  throw new Error(`This page cannot show its scene: ${what}.`);
}

/** Reads the scene from a text. Throws an Error that says what is wrong with it. */
export function readScene(text: string): Scene {
  let scene: Scene | null;
  try {
    scene = JSON.parse(text) as Scene | null;
  } catch (error) {
    fail(`it is no JSON: ${(error as Error).message}`);
  }
  if (scene === null) fail("none has been written into it");
  if (scene.format !== FORMAT) fail(`its format is "${scene.format}", this page reads "${FORMAT}"`);
  const n = scene.bodies.length;
  const body = (index: number, of: string) => {
    if (!(Number.isInteger(index) && index >= 0 && index < n)) fail(`${of} is on body ${index}, there are 0 to ${n - 1}`);
  };
  if (scene.q.length !== scene.nq) fail(`q has ${scene.q.length} numbers, nq is ${scene.nq}`);
  scene.bodies.forEach((b, i) => {
    if (i > 0 && !(b.predecessor >= 0 && b.predecessor < i)) {
      fail(`the predecessor of body ${i}, "${b.name}", is ${b.predecessor}, which does not come before it`);
    }
  });
  scene.frames.forEach((f) => body(f.body, `frame "${f.name}"`));
  scene.shapes.forEach((s, k) => body(s.body, `shape ${k}`));
  scene.loops.forEach((l) => l.ends.forEach((end) => body(end.body, `loop "${l.name}"`)));
  scene.lines?.forEach((line, k) => line.ends.forEach((end) => body(end.body, `line ${k}`)));
  const { motion } = scene;
  if (motion) {
    const k = motion.t.length;
    if (k === 0) fail("its motion has no sample");
    motion.load_frames?.forEach((frame) => body(frame.body, `the load on "${frame.name}"`));
    for (const key of ["q", "v", "tau", "twists", "wrenches", "momenta", "contacts", "loop_wrenches", "loads",
                       "tensions"] as const) {
      const samples = motion[key];
      if (samples && samples.length !== k) fail(`its motion has ${samples.length} samples of ${key} and ${k} of t`);
    }
  }
  return scene;
}
