/**
 * Kinematics computed apart from the page, with 4 × 4 matrices and their exponential alone:
 * C_i = C_p A_p⁻¹ A_i exp(X̂ q) for a joint screw X in the
 * frame of the body, and twists from differences of poses.
 */

export const identity = () => [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]];
export const times = (a, b) => a.map((row) => b[0].map((_, j) => row.reduce((sum, x, k) => sum + x * b[k][j], 0)));
const plus = (a, b, s = 1) => a.map((row, i) => row.map((x, j) => x + s * b[i][j]));
const scaled = (a, s) => a.map((row) => row.map((x) => s * x));
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const dot = (a, b) => a.reduce((sum, x, k) => sum + x * b[k], 0);
export const apply = (C, x) => [0, 1, 2].map((i) => dot(C[i].slice(0, 3), x) + C[i][3]);
export const turn = (C, x) => [0, 1, 2].map((i) => dot(C[i].slice(0, 3), x));

export function inverse(C) {
  const R = [0, 1, 2].map((i) => [0, 1, 2].map((j) => C[j][i]));
  const r = R.map((row) => -dot(row, [C[0][3], C[1][3], C[2][3]]));
  return [...R.map((row, i) => [...row, r[i]]), [0, 0, 0, 1]];
}

/** exp of the 4 × 4 matrix of a screw (w; v): a series, after halving often enough. */
export function exp([wx, wy, wz, vx, vy, vz]) {
  const halvings = 5;
  const X = scaled([[0, -wz, wy, vx], [wz, 0, -wx, vy], [-wy, wx, 0, vz], [0, 0, 0, 0]], 2 ** -halvings);
  let term = identity();
  let sum = identity();
  for (let k = 1; k < 14; ++k) {
    term = scaled(times(term, X), 1 / k);
    sum = plus(sum, term);
  }
  for (let k = 0; k < halvings; ++k) sum = times(sum, sum);
  return sum;
}

/** x y z, qx qy qz qw of a matrix, and back. */
export function poseOf(C) {
  const m = (i, j) => C[i][j];
  const squares = [1 + m(0, 0) - m(1, 1) - m(2, 2), 1 - m(0, 0) + m(1, 1) - m(2, 2), 1 - m(0, 0) - m(1, 1) + m(2, 2), 1 + m(0, 0) + m(1, 1) + m(2, 2)];
  const k = squares.indexOf(Math.max(...squares));
  const s = 2 * Math.sqrt(squares[k]);
  const off = [[m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1)], [m(1, 0) + m(0, 1), m(0, 2) + m(2, 0), m(2, 1) + m(1, 2)]];
  const q = [
    [s / 4, off[1][0] / s, off[1][1] / s, off[0][0] / s],
    [off[1][0] / s, s / 4, off[1][2] / s, off[0][1] / s],
    [off[1][1] / s, off[1][2] / s, s / 4, off[0][2] / s],
    [off[0][0] / s, off[0][1] / s, off[0][2] / s, s / 4],
  ][k];
  return [m(0, 3), m(1, 3), m(2, 3), ...q];
}

export function matrixOf([x, y, z, qx, qy, qz, qw]) {
  const angle = 2 * Math.atan2(Math.hypot(qx, qy, qz), qw);
  const s = Math.hypot(qx, qy, qz) || 1;
  const R = exp([(angle * qx) / s, (angle * qy) / s, (angle * qz) / s, 0, 0, 0]);
  return R.map((row, i) => (i < 3 ? [...row.slice(0, 3), [x, y, z][i]] : row));
}

/** For each kind of joint its coordinates at rest, the number of its velocities, and its displacement in its own frame. */
export const JOINTS = {
  revolute: { rest: [0], nv: 1, displacement: ([angle]) => exp([0, 0, angle, 0, 0, 0]) },
  prismatic: { rest: [0], nv: 1, displacement: ([x]) => exp([0, 0, 0, 0, 0, x]) },
  helical: { rest: [0], nv: 1, displacement: ([angle], pitch) => exp([0, 0, angle, 0, 0, pitch * angle]) },
  planar: { rest: [0, 0, 0], nv: 3, displacement: ([angle, x, y]) => times(exp([0, 0, 0, x, y, 0]), exp([0, 0, angle, 0, 0, 0])) },
  spherical: { rest: [0, 0, 0, 1], nv: 3, displacement: (q) => matrixOf([0, 0, 0, ...q]) },
  free: { rest: [0, 0, 0, 1, 0, 0, 0], nv: 6, displacement: (q) => matrixOf([...q.slice(4), ...q.slice(0, 4)]) },
};

const known = new WeakMap();

/**
 * What of a joint does not depend on q: from the predecessor at
 * the reference poses to the joint, and from it to the body.
 */
function constants(scene, body) {
  if (!known.has(body)) {
    const S = matrixOf(body.S_self);
    const A_p = body.predecessor === 0 ? identity() : matrixOf(scene.bodies[body.predecessor].A);
    known.set(body, { before: times(times(inverse(A_p), matrixOf(body.A)), S), behind: inverse(S) });
  }
  return known.get(body);
}

/**
 * Poses of all bodies of a scene, by product of exponentials about the joint screws at the reference poses A.
 */
export function poses(scene, q) {
  const all = [identity()];
  scene.bodies.slice(1).forEach((body, k) => {
    const { joint } = body;
    const { before, behind } = constants(scene, body);
    const x = joint.leader
      ? [joint.leader.ratio * q[scene.bodies[joint.leader.joint].joint.iq] + joint.leader.offset]
      : q.slice(joint.iq, joint.iq + joint.nq);
    all[k + 1] = times(times(times(all[body.predecessor], before), JOINTS[joint.kind].displacement(x, joint.pitch)), behind);
  });
  return all;
}

/**
 * Spatial twists of bodies from poses a moment before and
 * after: the antisymmetric part of C' C⁻¹ and its last column.
 */
export function twists(before, after, dt) {
  return before.slice(1).map((C0, k) => {
    const C1 = after[k + 1];
    const middle = scaled(plus(C0, C1), 0.5);
    const dC = scaled(plus(C1, C0, -1), 1 / dt);
    const V = times(dC, inverse(middle));
    const w = [(V[2][1] - V[1][2]) / 2, (V[0][2] - V[2][0]) / 2, (V[1][0] - V[0][1]) / 2];
    const r = [middle[0][3], middle[1][3], middle[2][3]];
    const dr = [dC[0][3], dC[1][3], dC[2][3]];
    const moment = cross(r, w);
    return [...w, ...dr.map((x, i) => x + moment[i])];
  });
}
