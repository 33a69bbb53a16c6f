import { KINDS, type Group } from "./joint_kinds";
import { carried, combined, displacement, moved, rate } from "./se3";
import type { Motion, Scene } from "./scene";

/** A moment of a motion: between samples `index` and `index + 1`, at `fraction` of the way. */
export interface Moment {
  index: number;
  fraction: number;
}

export function momentOf(times: readonly number[], t: number): Moment {
  let low = 0;
  let high = times.length - 1;
  if (high === 0 || t <= times[0]) return { index: 0, fraction: 0 };
  if (t >= times[high]) return { index: high - 1, fraction: 1 };
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle;
  }
  return { index: low, fraction: (t - times[low]) / (times[high] - times[low]) };
}

export function interpolate(samples: readonly number[][], { index, fraction }: Moment): number[] {
  const a = samples[index];
  const b = samples[Math.min(index + 1, samples.length - 1)];
  return a.map((x, k) => x + fraction * (b[k] - x));
}

/**
 * q between two samples, from q and v of both, on the group. For joints of several
 * velocities it is (q_k ⊕ (t - t_k) z) ⊕ x(t) with the mean velocity z and a cubic x, so
 * that a body may turn by any angle from one sample to the next; for the other joints it
 * is a cubic. `axode::Trajectory` has the same rule, with accelerations and quintics.
 */
export function coordinatesAt(scene: Scene, motion: Motion, { index, fraction }: Moment): number[] {
  const samples = [index, Math.min(index + 1, motion.t.length - 1)];
  const exact = fraction === 0 || samples[0] === samples[1] ? 0 : fraction === 1 ? 1 : null;
  if (exact !== null) return motion.q[samples[exact]].slice();
  const h = motion.t[samples[1]] - motion.t[samples[0]];
  const q = new Array<number>(scene.nq);
  scene.bodies.slice(1).forEach(({ joint }) => {
    const { kind, iq, nq, iv, nv, leader } = joint;
    if (leader) return;
    const { group } = KINDS[kind];
    const [a, b] = samples.map((k) => motion.q[k].slice(iq, iq + nq));
    const [v_a, v_b] = samples.map((k) => motion.v[k].slice(iv, iv + nv));
    const between = group ? onGroup(group, fraction, h, a, b, v_a, v_b) : [onCubic(fraction, b[0] - a[0], h * v_a[0], h * v_b[0]) + a[0]];
    between.forEach((x, k) => (q[iq + k] = x));
  });
  return q;
}

/**
 * The weights, at s in [0, 1], of the value at 1 and of the rates at 0 and 1 in the cubic whose value at 0 is
 * 0.
 */
function weights(s: number): [number, number, number] {
  return [s * s * (3 - 2 * s), s * (1 - s) ** 2, s * s * (s - 1)];
}

function onCubic(s: number, end: number, rate_0: number, rate_1: number): number {
  const [x, x_0, x_1] = weights(s);
  return x * end + x_0 * rate_0 + x_1 * rate_1;
}

function onGroup(group: Group, s: number, h: number, a: number[], b: number[], v_a: number[], v_b: number[]): number[] {
  const [from, to] = [group.place(a), group.place(b)];
  const [V_a, V_b] = [group.screw(v_a), group.screw(v_b)];
  const z = combined([1 / 2, V_a], [1 / 2, V_b]);
  const rest = displacement(moved(from, combined([h, z])), to);
  const rate_0 = combined([1, V_a], [-1, z]);
  const rate_1 = rate(rest, combined([1, V_b], [-1, carried(rest, z)]));
  const [x, x_0, x_1] = weights(s);
  const step = combined([s * h, z]);
  const left = combined([x, rest], [h * x_0, rate_0], [h * x_1, rate_1]);
  return group.coordinates(moved(moved(from, step), left), a[0] + step.w.z + left.w.z);
}

/** The coordinates q ⊕ u of all joints after a displacement u, which has the order of velocities. */
export function advanced(scene: Scene, q: readonly number[], u: readonly number[]): number[] {
  const next = q.slice();
  for (const { joint } of scene.bodies.slice(1)) {
    const { kind, iq, nq, iv, nv, leader } = joint;
    if (leader) continue;
    const { group } = KINDS[kind];
    const step = u.slice(iv, iv + nv);
    if (step.every((part) => part === 0)) continue;
    const to = group ? group.coordinates(moved(group.place(q.slice(iq, iq + nq)), group.screw(step)), q[iq] + step[0]) : [q[iq] + step[0]];
    to.forEach((x, k) => (next[iq + k] = x));
  }
  return next;
}
