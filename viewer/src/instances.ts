import { Color, DynamicDrawUsage, InstancedMesh, Matrix4, type BufferGeometry, type Material } from "three";

/** One thing of many that look alike: where it is on its body. */
export interface Item {
  body: number;
  pose: Matrix4;
  color?: string | Color;
  /** Whether its size is in units of symbols, or in metres. */
  symbol?: boolean;
}

/** Things of one geometry and material, each fixed to a body, drawn in one call. */
export class Instances extends InstancedMesh {
  constructor(
    geometry: BufferGeometry,
    material: Material,
    readonly items: Item[],
  ) {
    super(geometry, material, items.length);
    this.instanceMatrix.setUsage(DynamicDrawUsage);
    this.frustumCulled = false;
    this.paint();
  }

  /** Gives every item its own colour, those of a chosen body another. */
  paint(chosen = -1, color?: string): void {
    if (!this.items.some((item) => item.color)) return;
    this.items.forEach((item, k) => {
      this.setColorAt(k, new Color(item.body === chosen && color ? color : (item.color ?? "#ffffff")));
    });
    this.instanceColor!.needsUpdate = true;
  }

  place(poses: readonly Matrix4[], unit: number): void {
    const matrix = new Matrix4();
    const scale = new Matrix4().makeScale(unit, unit, unit);
    this.items.forEach(({ body, pose, symbol }, k) => {
      matrix.multiplyMatrices(poses[body], pose);
      if (symbol) matrix.multiply(scale);
      this.setMatrixAt(k, matrix);
    });
    this.instanceMatrix.needsUpdate = true;
    this.boundingSphere = null;
    this.boundingBox = null;
  }
}
