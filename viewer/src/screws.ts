import { Matrix4, Vector3 } from "three";

/** Screw coordinates (angular; linear) of a twist, or (moment; force) of a wrench, about one point. */
export interface Screw {
  w: Vector3;
  v: Vector3;
}

export function screwOf(x: readonly number[]): Screw {
  return { w: new Vector3(x[0], x[1], x[2]), v: new Vector3(x[3], x[4], x[5]) };
}

/** The axis of a screw: a point on it, its direction, and its pitch. A pure translation has none. */
export interface ScrewAxis {
  /** The point nearest to the origin of the frame in which the screw is written. */
  p: Vector3;
  e: Vector3;
  /** m/rad */
  pitch: number;
}

/** The axis of a screw (w; v): e = w/|w|, p = w × v/|w|², h = w·v/|w|². It is null if w is below `least`. */
export function axisOf({ w, v }: Screw, least: number): ScrewAxis | null {
  const ww = w.lengthSq();
  if (!(ww > least * least)) return null;
  return {
    p: new Vector3().crossVectors(w, v).divideScalar(ww),
    e: w.clone().divideScalar(Math.sqrt(ww)),
    pitch: w.dot(v) / ww,
  };
}

/** The point of an axis that is nearest to x. */
export function nearest({ p, e }: ScrewAxis, x: Vector3): Vector3 {
  return p.clone().addScaledVector(e, x.clone().sub(p).dot(e));
}

/**
 * In which axes a screw of a body is written and about which point: the four representations
 * of axode. In `body` both parts are in body axes, in `hybrid` both in inertial axes, in
 * `mixed` the first part (of a twist the angular one, of a wrench the moment) is in body
 * axes and the second in inertial ones; all three about the origin of the body's frame.
 */
export type Representation = "body" | "spatial" | "hybrid" | "mixed";

export const representations: Record<Representation, { title: string; where: string; axes: string }> = {
  body: { title: "body-fixed", where: "about the origin of the body", axes: "numbers in body axes" },
  spatial: { title: "spatial", where: "about the inertial origin", axes: "numbers in inertial axes" },
  hybrid: { title: "hybrid", where: "about the origin of the body", axes: "numbers in inertial axes" },
  mixed: {
    title: "mixed",
    where: "about the origin of the body",
    axes: "first three numbers in body axes, last three in inertial axes",
  },
};

/** A twist about the point r instead of the inertial origin: v + w × r. */
export function twistAbout({ w, v }: Screw, r: Vector3): Screw {
  return { w: w.clone(), v: v.clone().add(new Vector3().crossVectors(w, r)) };
}

/** A wrench (or momentum) (moment; force) about the point r instead of the inertial origin: m - r × f. */
export function wrenchAbout({ w, v }: Screw, r: Vector3): Screw {
  return { w: w.clone().sub(new Vector3().crossVectors(r, v)), v: v.clone() };
}

/** The numbers of a spatial twist or wrench of a body with pose C in a representation. */
export function represent(spatial: Screw, dual: boolean, C: Matrix4, representation: Representation): number[] {
  if (representation === "spatial") return [...spatial.w.toArray(), ...spatial.v.toArray()];
  const at = new Vector3().setFromMatrixPosition(C);
  const { w, v } = dual ? wrenchAbout(spatial, at) : twistAbout(spatial, at);
  const intoBody = new Matrix4().extractRotation(C).transpose();
  const first = representation === "hybrid" ? w : w.clone().applyMatrix4(intoBody);
  const second = representation === "body" ? v.clone().applyMatrix4(intoBody) : v;
  return [...first.toArray(), ...second.toArray()];
}
