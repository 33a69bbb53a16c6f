import { Color, DynamicDrawUsage, InstancedMesh, Matrix4, type BufferGeometry, type Material } from "three";

/** One of many things of the same shape, with its pose on its body. */
export interface Item {
  body: number;
  pose: Matrix4;
  color?: string | Color;
  /** Whether its size is in units of symbols; otherwise it is in metres. */
  symbol?: boolean;
}

/** Things of one geometry and material, each of them fixed to a body. One call draws all of them. */
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

  /** Gives every thing its own colour, except those of the chosen body, which get another one. */
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
