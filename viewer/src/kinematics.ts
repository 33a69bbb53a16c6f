import { Matrix4, Quaternion, Vector3 } from "three";
import { KINDS } from "./joint_kinds";
import type { Body, Pose, Scene } from "./scene";

/** The matrix of a pose x y z, qx qy qz qw. */
export function matrixOf(pose: Pose): Matrix4 {
  const [x, y, z, qx, qy, qz, qw] = pose;
  return new Matrix4().compose(new Vector3(x, y, z), new Quaternion(qx, qy, qz, qw), new Vector3(1, 1, 1));
}

/** Poses of all bodies for coordinates q: C = C_p S_prev J(q) S_self⁻¹ along the tree. */
export class Tree {
  /** Pose of each body in the inertial frame; [0] is the ground. */
  readonly poses: Matrix4[];
  private readonly before: Matrix4[];
  private readonly after: Matrix4[];

  constructor(private readonly bodies: readonly Body[]) {
    this.poses = bodies.map(() => new Matrix4());
    this.before = bodies.map((body, i) => (i === 0 ? new Matrix4() : matrixOf(body.S_prev)));
    this.after = bodies.map((body, i) => (i === 0 ? new Matrix4() : matrixOf(body.S_self).invert()));
  }

  /** The coordinates of joint i; those of a coupled joint follow from its leader. */
  coordinates(i: number, q: readonly number[]): number[] {
    const { iq, nq, leader } = this.bodies[i].joint;
    return leader ? [leader.ratio * this.coordinates(leader.joint, q)[0] + leader.offset] : q.slice(iq, iq + nq);
  }

  update(q: readonly number[]): void {
    for (let i = 1; i < this.bodies.length; ++i) {
      const { kind, pitch } = this.bodies[i].joint;
      const J = KINDS[kind].displacement(this.coordinates(i, q), pitch);
      this.poses[i]
        .multiplyMatrices(this.poses[this.bodies[i].predecessor], this.before[i])
        .multiply(J)
        .multiply(this.after[i]);
    }
  }

  /** Joint frame i, on its body. */
  jointFrame(i: number): Matrix4 {
    return this.poses[i].clone().multiply(matrixOf(this.bodies[i].S_self));
  }
}

/**
 * The point of body i, in its own frame, at which its joint is drawn. A prismatic joint may have a direction and no place,
 * and a free one has neither; they are drawn at the centre of mass.
 */
export function placeOfJoint({ joint: { kind }, S_self, mass, com }: Body): Vector3 {
  return !KINDS[kind].hasPlace && mass > 0 ? new Vector3(...com) : new Vector3(S_self[0], S_self[1], S_self[2]);
}

/** The normal of the planes in which all bodies move; null if there are none. */
export function planeNormal(scene: Scene, poses: readonly Matrix4[]): Vector3 | null {
  const axes: Record<"revolute" | "prismatic", Vector3[]> = { revolute: [], prismatic: [] };
  for (const [i, { joint, S_self }] of scene.bodies.entries()) {
    if (i === 0) continue;
    if (joint.kind !== "revolute" && joint.kind !== "prismatic") return null;
    axes[joint.kind].push(new Vector3(0, 0, 1).transformDirection(poses[i].clone().multiply(matrixOf(S_self))));
  }
  const normal = axes.revolute[0] ?? null;
  const isPlanar = axes.revolute.every((axis) => Math.abs(axis.dot(normal)) > 0.9999) && axes.prismatic.every((axis) => !normal || Math.abs(axis.dot(normal)) < 0.01);
  return isPlanar ? normal : null;
}

/** The mass of all bodies and their centre of mass. */
export function centreOfMass(scene: Scene, poses: readonly Matrix4[]): { mass: number; com: Vector3 } {
  const com = new Vector3();
  let mass = 0;
  scene.bodies.slice(1).forEach((body, k) => {
    com.addScaledVector(new Vector3(...body.com).applyMatrix4(poses[k + 1]), body.mass);
    mass += body.mass;
  });
  return { mass, com: mass > 0 ? com.divideScalar(mass) : com };
}

/** Quaternion of a rotation vector. */
export function expQuaternion(x: Vector3): Quaternion {
  const angle = x.length();
  return angle === 0 ? new Quaternion() : new Quaternion().setFromAxisAngle(x.clone().divideScalar(angle), angle);
}

/** Rotation vector of a quaternion, of length at most π. */
export function logQuaternion(q: Quaternion): Vector3 {
  const sign = q.w < 0 ? -1 : 1;
  const v = new Vector3(q.x, q.y, q.z).multiplyScalar(sign);
  const s = v.length();
  return s === 0 ? v : v.multiplyScalar((2 * Math.atan2(s, sign * q.w)) / s);
}
