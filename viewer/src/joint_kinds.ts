import { type BufferGeometry, Matrix4, Quaternion, Vector3 } from "three";
import { ball, hinge, plate, screwThread, slider } from "./glyphs";
import type { Screw } from "./screws";
import type { Place } from "./se3";

/** What a number of a joint measures, with its units. */
export const ANGLE = { coordinate: "rad", velocity: "rad/s", force: "N m" };
export const LENGTH = { coordinate: "m", velocity: "m/s", force: "N" };

/** Maps between the numbers of a joint with several velocities and a displacement or a twist in its own frame. */
export interface Group {
  place(x: readonly number[]): Place;
  /** The coordinates of a place; those of a planar joint count turns by `angle`. */
  coordinates(place: Place, angle: number): number[];
  screw(v: readonly number[]): Screw;
}

/** All that the page knows of a kind of joint. */
interface Kind {
  /** The units of its velocities; the angular ones come first. */
  units: (typeof ANGLE)[];
  /** The names of its directions on sliders, and of its coordinates and velocities in plots. */
  sliders: string[];
  coordinates: string[];
  velocities: string[];
  /** J(x): its displacement in its own frame, whose z-axis is its axis. */
  displacement(x: readonly number[], pitch: number): Matrix4;
  group?: Group;
  /** Whether its first four coordinates are a quaternion. */
  hasQuaternion: boolean;
  /** Whether its axis or its centre is in one place, where it is drawn. */
  hasPlace: boolean;
  hasPitch: boolean;
  /** Its symbol, about one unit large, along z, if it has one. `lead` is how far a thread advances in a turn. */
  symbol?(sides: number, lead: number): BufferGeometry;
}

const TURNS = ["wx", "wy", "wz"];
const QUATERNION = ["qx", "qy", "qz", "qw"];
const turned = (x: readonly number[]) => new Quaternion(x[0], x[1], x[2], x[3]);
const simple = { sliders: [""], coordinates: [""], velocities: [""], hasQuaternion: false, hasPlace: true, hasPitch: false };
const turning = {
  hasQuaternion: true,
  hasPitch: false,
  group: {
    place: (x: readonly number[]) => ({ turn: turned(x), r: new Vector3(x[4] ?? 0, x[5] ?? 0, x[6] ?? 0) }),
    screw: (v: readonly number[]) => ({ w: new Vector3(v[0], v[1], v[2]), v: new Vector3(v[3] ?? 0, v[4] ?? 0, v[5] ?? 0) }),
  },
};

/** Returns its argument, with the keys as a type. */
const table = <Name extends string>(kinds: Record<Name, Kind>) => kinds;

export const KINDS = table({
  revolute: { ...simple, units: [ANGLE], symbol: hinge, displacement: ([angle]) => new Matrix4().makeRotationZ(angle) },
  prismatic: {
    ...simple,
    units: [LENGTH],
    hasPlace: false,
    symbol: slider,
    displacement: ([x]) => new Matrix4().makeTranslation(0, 0, x),
  },
  helical: {
    ...simple,
    units: [ANGLE],
    hasPitch: true,
    symbol: screwThread,
    displacement: ([angle], pitch) => new Matrix4().makeRotationZ(angle).setPosition(0, 0, pitch * angle),
  },
  spherical: {
    ...turning,
    units: [ANGLE, ANGLE, ANGLE],
    sliders: ["rx", "ry", "rz"],
    coordinates: QUATERNION,
    velocities: TURNS,
    hasPlace: true,
    symbol: ball,
    displacement: (x) => new Matrix4().makeRotationFromQuaternion(turned(x).normalize()),
    group: { ...turning.group, coordinates: ({ turn }) => turn.toArray() },
  },
  planar: {
    ...simple,
    units: [ANGLE, LENGTH, LENGTH],
    sliders: ["θ", "x", "y"],
    coordinates: ["angle", "x", "y"],
    velocities: ["w", "vx", "vy"],
    symbol: plate,
    displacement: ([angle, x, y]) => new Matrix4().makeRotationZ(angle).setPosition(x, y, 0),
    group: {
      place: ([angle, x, y]) => ({ turn: new Quaternion().setFromAxisAngle(new Vector3(0, 0, 1), angle), r: new Vector3(x, y, 0) }),
      coordinates: ({ r }, angle) => [angle, r.x, r.y],
      screw: ([w, x, y]) => ({ w: new Vector3(0, 0, w), v: new Vector3(x, y, 0) }),
    },
  },
  free: {
    ...turning,
    units: [ANGLE, ANGLE, ANGLE, LENGTH, LENGTH, LENGTH],
    sliders: ["rx", "ry", "rz", "x", "y", "z"],
    coordinates: [...QUATERNION, "x", "y", "z"],
    velocities: [...TURNS, "vx", "vy", "vz"],
    hasPlace: false,
    displacement: (x) => new Matrix4().makeRotationFromQuaternion(turned(x).normalize()).setPosition(x[4], x[5], x[6]),
    group: { ...turning.group, coordinates: ({ turn, r }) => [...turn.toArray(), ...r.toArray()] },
  },
});

export type JointKind = keyof typeof KINDS;
