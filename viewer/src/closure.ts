import { Matrix4 } from "three";
import { KINDS } from "./joint_kinds";
import { matrixOf, Tree } from "./kinematics";
import { advanced } from "./motion";
import type { Loop, Scene } from "./scene";

/** Residuals up to this count as closed. Lengths are in units of the size of the mechanism. */
const CLOSED = 1e-11;
/**
 * Loops with larger residuals are not closed before a joint
 * moves: they were opened on purpose, or cannot be closed.
 */
export const TORN = 1e-3;
/** Newton's method ends at residuals that only rounding leaves. */
const ROUNDING = 1e-14;
const ITERATIONS = 15;
/** Half the difference of coordinates with which residuals are differentiated. */
const DIFFERENCE = 1e-5;
/** Rows of the Jacobian that depend on others up to this part of the largest one count as redundant. */
const REDUNDANT = 1e-7;
/** The largest step of a moved joint, and the largest correction of the other joints for one step. */
const STEP = 0.1;
const CORRECTION = 0.5;
/** A joint that cannot move on by this part of its way has reached its end, unless it is at a dead point. */
const LEAST_PART = 1e-6;
/**
 * A joint moves on at most this often: where the loops stay
 * singular, steps stay so short that a page would stand still.
 */
const MOST_STEPS = 400;
/**
 * At a dead point other joints are moved aside by these steps, and the joint moves on by the step after them.
 */
const ASIDE = [0.05, -0.05, 0.2, -0.2];
const FROM_DEAD_POINT = 1e-3;

/** Where a joint was brought, and the part of its way that it went: 1 if it arrived. */
export interface Arrival {
  q: number[];
  part: number;
}

/** The equations of loop joints and couplings, and the motion of joints under them. */
export class Closure {
  private readonly tree: Tree;
  private readonly ends: [Matrix4, Matrix4][];
  /** Length that counts as 1, as an angle of 1 rad does. */
  private readonly size: number;
  /** What a velocity is multiplied by, in the order of v, so that its step has no unit. */
  private readonly scale: number[];
  private readonly driven: number[];

  constructor(private readonly scene: Scene) {
    const { bodies, loops } = scene;
    this.tree = new Tree(bodies);
    this.ends = loops.map((loop) => [matrixOf(loop.ends[0].pose), matrixOf(loop.ends[1].pose)]);
    const poses = [...bodies.slice(1).flatMap(({ S_prev, S_self }) => [S_prev, S_self]), ...loops.flatMap((loop) => loop.ends.map(({ pose }) => pose))];
    this.size = Math.max(...poses.map(([x, y, z]) => Math.hypot(x, y, z)), ...loops.map(({ kind, size }) => (kind === "universal" ? 0 : (size ?? 0)))) || 1;
    const joints = bodies.slice(1).map(({ joint }) => joint);
    this.scale = joints.flatMap(({ kind, nv }) => (nv === 0 ? [] : KINDS[kind].units.map(({ coordinate }) => (coordinate === "m" ? this.size : 1))));
    const anyPassive = joints.some(({ passive }) => passive);
    this.driven = joints.flatMap(({ passive, leader }, k) => (anyPassive && !passive && !leader ? [k + 1] : []));
  }

  /** Whether there is nothing to close. */
  get none(): boolean {
    return this.scene.loops.length === 0 && (this.scene.couplings ?? []).length === 0;
  }

  /** The residuals of all loops at q; angles in rad, lengths in units of the size of the mechanism. */
  private residuals(q: readonly number[]): number[] {
    this.tree.update(q);
    const ofJoints = this.scene.loops.flatMap((loop, k) => {
      const [a, b] = loop.ends.map(({ body }, end) => this.tree.poses[body].clone().multiply(this.ends[k][end]));
      return residualsOf(loop, a.invert().multiply(b), this.size);
    });
    const ofCouplings = (this.scene.couplings ?? []).map(({ terms, offset }) => terms.reduce((sum, [coordinate, factor]) => sum + factor * q[coordinate], -offset));
    return [...ofJoints, ...ofCouplings];
  }

  /** The largest residual at q; angles in rad, lengths in units of the size of the mechanism. */
  gap(q: readonly number[]): number {
    return Math.max(0, ...this.residuals(q).map(Math.abs));
  }

  /**
   * Closes the loops by Newton's method, with the least motion
   * of the velocities that are not held; null if that fails.
   */
  close(q: readonly number[], held: readonly boolean[]): number[] | null {
    const free = held.flatMap((isHeld, k) => (isHeld ? [] : [k]));
    let now = q.slice();
    let r = this.residuals(now);
    let before = Infinity;
    for (let k = 0; k < ITERATIONS; ++k) {
      const gap = Math.max(0, ...r.map(Math.abs));
      if (gap <= ROUNDING || (gap <= CLOSED && gap > 0.1 * before)) return now;
      if (!(gap < before) && k > 2) return gap <= CLOSED ? now : null;
      before = gap;
      const step = leastNormStep(this.jacobian(now, free, r.length), r);
      if (!step.every(Number.isFinite) || Math.hypot(...step) > CORRECTION) return null;
      now = advanced(this.scene, now, this.velocities(free, step));
      r = this.residuals(now);
    }
    return before <= CLOSED ? now : null;
  }

  /**
   * Moves the joint of a body along path(s), s from 0 to 1, and closes the loops on the way. The drives and
   * the joints that were chosen keep their coordinates if the loops allow it. If the loops end the way, the
   * last configuration that closes them is returned.
   */
  lead(from: readonly number[], body: number, path: (s: number) => number[], length: number, chosen: readonly number[]): Arrival {
    const { iq } = this.scene.bodies[body].joint;
    const sets = [[...this.driven, ...chosen], this.driven, chosen, []].map((bodies) => this.heldBy([body, ...bodies]));
    const masks = sets.filter((mask, k) => sets.findIndex((other) => String(other) === String(mask)) === k);
    const at = (s: number, others: readonly number[]) => {
      const moved = others.slice();
      path(s).forEach((x, k) => (moved[iq + k] = x));
      return moved;
    };
    let q = from.slice();
    let part = 0;
    const longest = Math.min(1, STEP / length);
    let last = 0; // length of the step before, 0 if it failed
    for (let step = longest, steps = 0; part < 1 && steps < MOST_STEPS; ++steps) {
      const next = Math.min(1, part + step);
      const closed = this.close(at(next, q), masks[0]);
      if (closed) {
        [q, part] = [closed, next];
        // A second step of one length succeeds only away from the end of the way: then steps grow again.
        [step, last] = step === last ? [Math.min(longest, 2 * step), 0] : [step, step];
      } else if (masks.length > 1) {
        masks.shift();
      } else if (step >= LEAST_PART) {
        step /= 2;
      } else {
        const beyond = Math.min(1, part + FROM_DEAD_POINT / length);
        const off = part > 0 ? [] : this.aside(q).map((other) => this.close(at(beyond, other), masks[0])).filter((found) => found !== null);
        if (off.length === 0) break;
        [q, part, step] = [off[0], beyond, longest];
      }
      if (!closed) last = 0;
    }
    return { q, part };
  }

  /** Configurations a little away from q along a velocity that the loops allow. */
  private aside(q: readonly number[]): number[][] {
    const every = this.scale.map((_, k) => k);
    const J = this.jacobian(q, every, this.residuals(q).length);
    const any = every.map((k) => Math.sin(1 + 1.7 * k));
    const forbidden = leastNormStep(J, J.map((row) => row.reduce((sum, a, k) => sum + a * any[k], 0)));
    const tangent = any.map((x, k) => x + forbidden[k]);
    const length = Math.hypot(...tangent);
    if (!(length > REDUNDANT)) return [];
    return ASIDE.map((step) => advanced(this.scene, q, this.velocities(every, tangent.map((x) => (step * x) / length))));
  }

  private heldBy(bodies: readonly number[]): boolean[] {
    const held = this.scale.map(() => false);
    for (const body of bodies) {
      const { iv, nv } = this.scene.bodies[body].joint;
      held.fill(true, iv, iv + nv);
    }
    return held;
  }

  /** Steps of the free velocities, with units. */
  private velocities(free: readonly number[], step: readonly number[]): number[] {
    const u = this.scale.map(() => 0);
    free.forEach((k, j) => (u[k] = step[j] * this.scale[k]));
    return u;
  }

  /** The rows of the derivative of the residuals along the free velocities, by central differences. */
  private jacobian(q: readonly number[], free: readonly number[], rows: number): number[][] {
    const columns = free.map((_, j) => {
      const at = (sign: number) => {
        const step = free.map((__, i) => (i === j ? sign * DIFFERENCE : 0));
        return this.residuals(advanced(this.scene, q, this.velocities(free, step)));
      };
      const [ahead, behind] = [at(1), at(-1)];
      return ahead.map((x, i) => (x - behind[i]) / (2 * DIFFERENCE));
    });
    return Array.from({ length: rows }, (_, i) => columns.map((column) => column[i]));
  }
}

/** What a loop joint forbids of the pose D of its second end in the frame of its first end. */
function residualsOf({ kind, pitch = 0, size = 0, wheel = false }: Loop, D: Matrix4, unit: number): number[] {
  const e = D.elements;
  const [x, y, z] = [e[12] / unit, e[13] / unit, e[14] / unit];
  const tilt = [e[8], e[9]];
  const turn = [(e[6] - e[9]) / 2, (e[8] - e[2]) / 2, (e[1] - e[4]) / 2];
  switch (kind) {
    case "fixed":
      return [x, y, z, ...turn];
    case "revolute":
      return [x, y, z, ...tilt];
    case "prismatic":
      return [x, y, ...turn];
    case "helical": {
      const lead = (2 * Math.PI * pitch) / unit;
      const ahead = z - (lead * Math.atan2(e[1] - e[4], e[0] + e[5])) / (2 * Math.PI);
      return [x, y, ...tilt, ahead - lead * Math.round(ahead / lead)];
    }
    case "cylindrical":
      return [x, y, ...tilt];
    case "spherical":
      return [x, y, z];
    case "planar":
      return [z, ...tilt];
    case "translational":
      return turn;
    case "universal":
      return [x, y, z, (size - e[10]) / Math.sqrt(1 - size * size)];
    case "rod":
      return [Math.hypot(x, y, z) - size / unit];
    case "rolling":
      return [z - (size / unit) * (wheel ? Math.hypot(e[8], e[9]) : 1)];
    default:
      return [];
  }
}

/** The shortest x with J x = -r, without the rows of J that depend on others. */
function leastNormStep(J: readonly number[][], r: readonly number[]): number[] {
  const rows = J.map((row, i) => ({ rest: row.slice(), target: -r[i] }));
  const x = new Array<number>(J[0]?.length ?? 0).fill(0);
  const norm = (row: readonly number[]) => Math.hypot(...row);
  const least = REDUNDANT * Math.max(0, ...J.map(norm));
  while (rows.length > 0) {
    const [pivot] = rows.splice(rows.reduce((best, { rest }, k) => (norm(rest) > norm(rows[best].rest) ? k : best), 0), 1);
    const length = norm(pivot.rest);
    if (!(length > least)) break;
    const e = pivot.rest.map((a) => a / length);
    const along = pivot.target / length;
    e.forEach((a, j) => (x[j] += along * a));
    for (const row of rows) {
      const share = row.rest.reduce((sum, a, j) => sum + a * e[j], 0);
      row.rest = row.rest.map((a, j) => a - share * e[j]);
      row.target -= share * along;
    }
  }
  return x;
}
