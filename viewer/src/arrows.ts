import { Group, InstancedMesh, Matrix4, MeshStandardMaterial, Quaternion, Vector3, type BufferGeometry } from "three";
import { cone, rod } from "./glyphs";

const Z = new Vector3(0, 0, 1);

/** Arrows of one colour. Arrows of angular quantities have two heads. */
export class Arrows extends Group {
  private readonly shafts: InstancedMesh;
  private readonly heads: InstancedMesh;
  private readonly headsEach: number;

  constructor(most: number, color: string, angular: boolean) {
    super();
    const material = new MeshStandardMaterial({ color, roughness: 0.5 });
    const many = (geometry: BufferGeometry, count: number) => {
      const mesh = new InstancedMesh(geometry, material, count);
      mesh.frustumCulled = false;
      this.add(mesh);
      return mesh;
    };
    this.headsEach = angular ? 2 : 1;
    this.shafts = many(rod(0.05, 0, 1), most);
    this.heads = many(cone(0.15, 0.42, 0), most * this.headsEach);
  }

  /**
   * Draws vectors, in metres of the drawing, at the points where they begin. Vectors too short to be seen are
   * left out.
   */
  show(vectors: { from: Vector3; vector: Vector3 }[], unit: number): void {
    let k = 0;
    const matrix = new Matrix4();
    const scale = new Vector3();
    for (const { from, vector } of vectors) {
      const length = vector.length();
      if (!(length > 0.02 * unit)) continue;
      const turn = new Quaternion().setFromUnitVectors(Z, vector.clone().divideScalar(length));
      const size = Math.min(unit, length / (0.45 * (this.headsEach + 0.5)));
      const shaft = length - 0.4 * size;
      this.shafts.setMatrixAt(k, matrix.compose(from, turn, scale.set(size, size, shaft)));
      for (let head = 0; head < this.headsEach; ++head) {
        const tip = from.clone().addScaledVector(vector, (length - 0.36 * size * head) / length);
        this.heads.setMatrixAt(k * this.headsEach + head, matrix.compose(tip, turn, scale.setScalar(size)));
      }
      ++k;
    }
    this.shafts.count = k;
    this.heads.count = k * this.headsEach;
    this.shafts.instanceMatrix.needsUpdate = true;
    this.heads.instanceMatrix.needsUpdate = true;
  }
}
