import { Quaternion } from "three";
import type { Joint, Motion, Scene } from "./scene";

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

/** q between two samples: quaternions along the shorter arc, all other coordinates along the line. */
export function coordinatesAt(scene: Scene, motion: Motion, moment: Moment): number[] {
  const q = interpolate(motion.q, moment);
  const a = motion.q[moment.index];
  const b = motion.q[Math.min(moment.index + 1, motion.q.length - 1)];
  scene.bodies.slice(1).forEach(({ joint }) => {
    if (!hasQuaternion(joint)) return;
    const from = new Quaternion().fromArray(a, joint.iq);
    from.slerp(new Quaternion().fromArray(b, joint.iq), moment.fraction).toArray(q, joint.iq);
  });
  return q;
}

export function hasQuaternion(joint: Joint): boolean {
  return joint.kind === "spherical" || joint.kind === "free";
}
