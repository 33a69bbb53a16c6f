import type { Vector3 } from "three";

/** The part of the samples of which no arrow is clipped. */
const USUAL = 0.95;
/** Values below this part of the largest one count as none. */
const NEGLIGIBLE = 1e-5;
/** Nothing is clipped if the largest value is at most so many times the usual one. */
const TRANSIENT = 2;

/** The value that is drawn as the longest arrow, and whether the arrows of larger values are clipped to it. */
export interface Scale {
  most: number;
  clips: boolean;
}

/**
 * The scale of the arrows of a motion, from the largest value at each of its samples: the largest of them, unless that is
 * much larger than nearly all others, as at an impact or at a start.
 */
export function scaleOf(largestAtSamples: readonly number[]): Scale {
  const largest = largestAtSamples.reduce((a, b) => Math.max(a, b), 0);
  if (largest === 0) return { most: 0, clips: false };
  const sorted = largestAtSamples.filter((x) => x > NEGLIGIBLE * largest).sort((a, b) => a - b);
  const usual = sorted[Math.floor(USUAL * (sorted.length - 1))];
  return largest > TRANSIENT * usual ? { most: usual, clips: true } : { most: largest, clips: false };
}

/** Turns a vector into its arrow, which is as long as `long` if its value is the largest of the scale or larger. */
export function toArrow(vector: Vector3, { most }: Scale, long: number): Vector3 {
  return vector.multiplyScalar(long / most).clampLength(0, long);
}
