import { Quaternion, Vector3 } from "three";
import { expQuaternion, logQuaternion } from "./kinematics";
import type { Screw } from "./screws";

/** A point of SE(3). */
export interface Place {
  turn: Quaternion;
  r: Vector3;
}

/** a x + b y + ... of screws. */
export function combined(...terms: [number, Screw][]): Screw {
  const sum: Screw = { w: new Vector3(), v: new Vector3() };
  for (const [factor, { w, v }] of terms) {
    sum.w.addScaledVector(w, factor);
    sum.v.addScaledVector(v, factor);
  }
  return sum;
}

const cross = (a: Vector3, b: Vector3) => new Vector3().crossVectors(a, b);

/** (1 - cos θ)/θ² and (θ - sin θ)/θ³. */
function ofDexp(theta: number): [number, number] {
  if (theta < 1e-6) return [1 / 2, 1 / 6];
  const half = Math.sin(theta / 2);
  return [(2 * half * half) / theta ** 2, (theta - Math.sin(theta)) / theta ** 3];
}

/** g = (1 - θ/2 cot(θ/2))/θ², and its derivative by θ². */
function ofDexpInverse(theta: number): [number, number] {
  const s = theta * theta;
  if (theta < 0.05) return [1 / 12 + s / 720 + (s * s) / 30240, 1 / 720 + s / 15120];
  const [sine, cosine] = [Math.sin(theta / 2), Math.cos(theta / 2)];
  const u = (theta * cosine) / (2 * sine);
  const du = (cosine / sine - theta / (2 * sine * sine)) / (4 * theta);
  const g = (1 - u) / s;
  return [g, (-du - g) / s];
}

/** C exp X. */
export function moved({ turn, r }: Place, { w, v }: Screw): Place {
  const [b, c] = ofDexp(w.length());
  const wv = cross(w, v);
  const step = v.clone().addScaledVector(wv, b).addScaledVector(cross(w, wv), c);
  return { turn: turn.clone().multiply(expQuaternion(w)).normalize(), r: step.applyQuaternion(turn).add(r) };
}

/** The X with C exp X = D, by the shorter way round. */
export function displacement(C: Place, D: Place): Screw {
  const back = C.turn.clone().conjugate();
  const w = logQuaternion(back.clone().multiply(D.turn));
  const r = D.r.clone().sub(C.r).applyQuaternion(back);
  const wr = cross(w, r);
  return { w, v: r.clone().addScaledVector(wr, -1 / 2).addScaledVector(cross(w, wr), ofDexpInverse(w.length())[0]) };
}

/** Ad_{exp(-X)} Z. */
export function carried(X: Screw, Z: Screw): Screw {
  const { turn, r } = moved({ turn: new Quaternion(), r: new Vector3() }, X);
  const back = turn.conjugate();
  return { w: Z.w.clone().applyQuaternion(back), v: Z.v.clone().sub(cross(r, Z.w)).applyQuaternion(back) };
}

/** dexp⁻¹_{-X} Z: the X' with which C exp X has the velocity Z. */
export function rate({ w, v }: Screw, Z: Screw): Screw {
  const [g, dg] = ofDexpInverse(w.length());
  const [wz, wv, vz] = [cross(w, Z.w), cross(w, Z.v), cross(v, Z.w)];
  const wwz = cross(w, wz);
  return {
    w: Z.w.clone().addScaledVector(wz, 1 / 2).addScaledVector(wwz, g),
    v: Z.v
      .clone()
      .addScaledVector(wv.clone().add(vz), 1 / 2)
      .addScaledVector(cross(w, wv.add(vz)).add(cross(v, wz)), g)
      .addScaledVector(wwz, 2 * w.dot(v) * dg),
  };
}
