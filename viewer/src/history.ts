import type { Matrix4 } from "three";
import { Tree } from "./kinematics";
import type { Scene } from "./scene";

/**
 * Poses of all bodies at samples of the motion, which are evenly spread and not more than a given number.
 * They are computed when they are first needed.
 */
export class History {
  readonly indices: number[];
  private made: Matrix4[][] | null = null;

  constructor(
    private readonly scene: Scene,
    most = 500,
  ) {
    const count = scene.motion ? scene.motion.t.length : 0;
    const steps = Math.min(count, most);
    this.indices = Array.from({ length: steps }, (_, k) => (steps === 1 ? 0 : Math.round((k * (count - 1)) / (steps - 1))));
  }

  /** poses[k][i] is the pose of body i at the sample indices[k]. */
  get poses(): Matrix4[][] {
    this.made ??= this.indices.map((index) => {
      const tree = new Tree(this.scene.bodies);
      tree.update(this.scene.motion!.q[index]);
      return tree.poses;
    });
    return this.made;
  }
}
