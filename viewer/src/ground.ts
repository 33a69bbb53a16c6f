import type { Vector3 } from "three";

/** Heights that differ by less than this part of the size of the scene count as equal. */
const LEVEL = 1e-3;

/** The height at which the ground is drawn: that of the lowest of the points, or 0 where this is nearly the same. */
export function heightOfGround(points: readonly Vector3[], up: Vector3, size: number): number {
  const lowest = points.reduce((height, point) => Math.min(height, point.dot(up)), Infinity);
  return Number.isFinite(lowest) && Math.abs(lowest) > LEVEL * size ? lowest : 0;
}
