import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DoubleSide,
  Group,
  LineBasicMaterial,
  LineSegments,
  Matrix4,
  Mesh,
  MeshStandardMaterial,
  Vector3,
} from "three";
import type { History } from "./history";
import type { Scene } from "./scene";
import { axisOf, nearest, screwOf } from "./screws";

/**
 * The instantaneous screw axis at one time: its direction, and the point from which it is drawn to both
 * sides.
 */
export interface Generator {
  centre: Vector3;
  e: Vector3;
  /** How opaque it is drawn: from 1 at the centre of mass down to 0 far away from it. */
  clear: number;
}

/**
 * The two axodes of a body. An entry is null if the body does not turn, or turns about an axis too far away
 * to draw.
 */
export interface Axodes {
  /** In the inertial frame. */
  fixed: (Generator | null)[];
  /** In the frame of the body. */
  moving: (Generator | null)[];
}

/** Angular velocities below this part of the largest one count as zero. */
const LEAST_TURNING = 1e-3;

/** The angular velocity below which body i counts as not turning, from its largest one in the motion. */
export function leastTurning(scene: Scene, i: number): number {
  const twists = scene.motion?.twists ?? [];
  const most = twists.reduce((w, sample) => Math.max(w, Math.hypot(...sample[i - 1].slice(0, 3))), 0);
  return Math.max(1e-9, LEAST_TURNING * most);
}

/**
 * The ruled surfaces that the instantaneous screw axis of body i sweeps over the motion. The centre of each
 * generator is the point nearest to the centre of mass, so that both surfaces show the same segment of it.
 * Generators fade with the distance from the centre of mass, and are not drawn beyond `far`.
 */
export function axodes(scene: Scene, history: History, i: number, far: number): Axodes {
  const fixed: (Generator | null)[] = [];
  const moving: (Generator | null)[] = [];
  const least = leastTurning(scene, i);
  let before: Vector3 | null = null;
  history.indices.forEach((index, k) => {
    const C = history.poses[k][i];
    const com = new Vector3(...scene.bodies[i].com).applyMatrix4(C);
    const axis = axisOf(screwOf(scene.motion!.twists![index][i - 1]), least);
    const centre = axis && nearest(axis, com);
    const clear = centre ? 1 - centre.distanceTo(com) / far : 0;
    if (!axis || !centre || clear <= 0) {
      fixed.push(null);
      moving.push(null);
      return;
    }
    const e: Vector3 = axis.e;
    if (before && before.dot(e) < 0) e.negate(); // an axis has no sense: keep the surface from flipping over
    before = e;
    fixed.push({ centre, e, clear });
    const intoBody = C.clone().invert();
    moving.push({ centre: centre.clone().applyMatrix4(intoBody), e: e.clone().transformDirection(intoBody), clear });
  });
  return { fixed, moving };
}

/** Positions along a generator, from -1 to 1, and the opacity of the surface there. */
const ALONG = [
  [-1, 0.1],
  [-0.7, 0.32],
  [0, 0.42],
  [0.7, 0.32],
  [1, 0.1],
];
const LINES = 72;

/** Whether two neighbouring generators belong to one surface; otherwise the axis has jumped between them. */
function together(a: Generator | null, b: Generator | null, half: number): boolean {
  return a !== null && b !== null && a.e.dot(b.e) > 0.7 && a.centre.distanceTo(b.centre) < 1.5 * half;
}

/** The surface of generators, its colour running from the first to the second over time, with rulings. */
export function ruledSurface(generators: (Generator | null)[], half: number, [from, to]: readonly string[]): Group {
  const n = generators.length;
  const points: number[] = [];
  const colorsAndAlphas: number[] = [];
  const faces: number[] = [];
  const linePoints: number[] = [];
  const lineColors: number[] = [];
  const every = Math.max(1, Math.round(n / LINES));
  const at = (g: Generator, s: number) => g.centre.clone().addScaledVector(g.e, s * half);
  generators.forEach((g, k) => {
    const color = new Color(from).lerp(new Color(to), n > 1 ? k / (n - 1) : 0);
    for (const [s, alpha] of ALONG) {
      points.push(...(g ? at(g, s).toArray() : [0, 0, 0]));
      colorsAndAlphas.push(color.r, color.g, color.b, g ? alpha * g.clear : 0);
    }
    if (g && k % every === 0) {
      for (let j = 0; j + 1 < ALONG.length; ++j) {
        for (const [s, alpha] of [ALONG[j], ALONG[j + 1]]) {
          linePoints.push(...at(g, s).toArray());
          lineColors.push(color.r, color.g, color.b, Math.min(1, 1.9 * alpha * g.clear));
        }
      }
    }
    if (k === 0 || !together(generators[k - 1], g, half)) return;
    const m = ALONG.length;
    for (let j = 0; j + 1 < m; ++j) {
      const [a, b] = [(k - 1) * m + j, k * m + j];
      faces.push(a, b, a + 1, a + 1, b, b + 1);
    }
  });
  const surface = new BufferGeometry()
    .setAttribute("position", new BufferAttribute(new Float32Array(points), 3))
    .setAttribute("color", new BufferAttribute(new Float32Array(colorsAndAlphas), 4))
    .setIndex(faces);
  surface.computeVertexNormals();
  const rulings = new BufferGeometry()
    .setAttribute("position", new BufferAttribute(new Float32Array(linePoints), 3))
    .setAttribute("color", new BufferAttribute(new Float32Array(lineColors), 4));
  const seen = { vertexColors: true, transparent: true, depthWrite: false };
  const group = new Group();
  group.matrixAutoUpdate = false;
  group.add(
    new Mesh(surface, new MeshStandardMaterial({ ...seen, side: DoubleSide, roughness: 0.4, metalness: 0.1 })),
    new LineSegments(rulings, new LineBasicMaterial(seen)),
  );
  return group;
}

/** Frees the memory of what ruledSurface() made. */
export function dispose(group: Group): void {
  for (const child of group.children as (Mesh | LineSegments)[]) {
    child.geometry.dispose();
    for (const material of [child.material].flat()) material.dispose();
  }
}

/** The pose whose z-axis is a generator. */
export function along({ centre, e }: { centre: Vector3; e: Vector3 }): Matrix4 {
  const side = Math.abs(e.x) < 0.6 ? new Vector3(1, 0, 0) : new Vector3(0, 1, 0);
  const y = new Vector3().crossVectors(e, side).normalize();
  return new Matrix4().makeBasis(new Vector3().crossVectors(y, e), y, e).setPosition(centre);
}
