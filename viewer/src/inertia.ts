import { Matrix4, Vector3 } from "three";

/**
 * Eigenvalues of a symmetric 3 × 3 matrix and, as columns, a
 * right-handed frame of eigenvectors; by Jacobi rotations.
 */
export function principalAxes([xx, yy, zz, xy, xz, yz]: readonly number[]): { moments: Vector3; axes: Matrix4 } {
  const a = [xx, xy, xz, xy, yy, yz, xz, yz, zz];
  const u = [1, 0, 0, 0, 1, 0, 0, 0, 1];
  for (let sweep = 0; sweep < 30; ++sweep) {
    for (const [p, r] of [[0, 1], [0, 2], [1, 2]]) {
      const apr = a[3 * p + r];
      if (apr === 0) continue;
      const theta = (a[4 * r] - a[4 * p]) / (2 * apr);
      const t = Math.abs(theta) > 1e150 ? 0.5 / theta : (theta < 0 ? -1 : 1) / (Math.abs(theta) + Math.hypot(theta, 1));
      const c = 1 / Math.hypot(t, 1);
      const s = t * c;
      for (let k = 0; k < 3; ++k) {
        [a[3 * k + p], a[3 * k + r]] = [c * a[3 * k + p] - s * a[3 * k + r], s * a[3 * k + p] + c * a[3 * k + r]];
        [u[3 * k + p], u[3 * k + r]] = [c * u[3 * k + p] - s * u[3 * k + r], s * u[3 * k + p] + c * u[3 * k + r]];
      }
      for (let k = 0; k < 3; ++k) {
        [a[3 * p + k], a[3 * r + k]] = [c * a[3 * p + k] - s * a[3 * r + k], s * a[3 * p + k] + c * a[3 * r + k]];
      }
    }
  }
  const axes = new Matrix4().set(u[0], u[1], u[2], 0, u[3], u[4], u[5], 0, u[6], u[7], u[8], 0, 0, 0, 0, 1);
  return { moments: new Vector3(a[0], a[4], a[8]), axes };
}

/** Semi-axes of the homogeneous ellipsoid that has this mass and these principal moments of inertia. */
export function ellipsoid(mass: number, { x, y, z }: Vector3): Vector3 {
  const semiAxis = (others: number, own: number) => Math.sqrt(Math.max(0, (2.5 * (others - own)) / mass));
  return mass > 0 ? new Vector3(semiAxis(y + z, x), semiAxis(x + z, y), semiAxis(x + y, z)) : new Vector3();
}
