import { BufferGeometry, BufferAttribute, Group, Matrix4, MeshStandardMaterial, Vector3 } from "three";
import { edgesOf } from "./edges";
import { Instances } from "./instances";
import { matrixOf } from "./kinematics";
import type { Layer, View } from "./layers";
import { colorOfBody, colors } from "./palette";
import type { Scene } from "./scene";

/** Two hinges, those of bodies a and b, that turn together: b = ratio a + offset. */
export interface Gearing {
  a: number;
  b: number;
  ratio: number;
  offset: number;
}

/** The joints that are coupled in pairs. */
function coupledJoints({ bodies, couplings }: Scene): Gearing[] {
  const bodyOf = (coordinate: number) => bodies.findIndex(({ joint }) => joint?.nq === 1 && joint.iq === coordinate);
  const leaders = bodies.flatMap(({ joint }, b) => (joint?.leader ? [{ a: joint.leader.joint, b, ratio: joint.leader.ratio, offset: joint.leader.offset }] : []));
  const pairs = (couplings ?? []).flatMap(({ terms, offset }) => {
    if (terms.length !== 2) return [];
    const [[p, f], [q, g]] = terms;
    return [{ a: bodyOf(p), b: bodyOf(q), ratio: -f / g, offset: offset / g }];
  });
  return [...leaders, ...pairs].filter(({ a, b }) => a > 0 && b > 0);
}

/**
 * The couplings that can be drawn as wheels: of two hinges on one body whose axes are parallel and apart. `turns` is the
 * ratio of their turns about one direction: negative for teeth, positive for a belt.
 */
export function gearings(scene: Scene): (Gearing & { turns: number })[] {
  return coupledJoints(scene).flatMap(({ a, b, ratio, offset }) => {
    const [one, other] = [scene.bodies[a], scene.bodies[b]];
    if (one.joint.kind !== "revolute" || other.joint.kind !== "revolute" || one.predecessor !== other.predecessor) return [];
    const sense = axisOf(one.S_prev).dot(axisOf(other.S_prev));
    if (Math.abs(sense) < 0.9999 || !Number.isFinite(ratio) || ratio === 0) return [];
    return across(scene, { a, b }).length() > 0 ? [{ a, b, ratio, offset, turns: ratio * Math.sign(sense) }] : [];
  });
}

const axisOf = (pose: Parameters<typeof matrixOf>[0]) => new Vector3(0, 0, 1).transformDirection(matrixOf(pose));
const pointOf = ([x, y, z]: readonly number[]) => new Vector3(x, y, z);

/** The vector from the axis of one wheel to that of the other, on the body that has both. */
function across({ bodies }: Scene, { a, b }: { a: number; b: number }): Vector3 {
  const z = axisOf(bodies[a].S_prev);
  const apart = pointOf(bodies[b].S_prev).sub(pointOf(bodies[a].S_prev));
  return apart.addScaledVector(z, -apart.dot(z));
}

/** The radii of two wheels at a distance from each other. Those of teeth touch, and a belt has room for both. */
export function radii(ratio: number, distance: number): [number, number] {
  const size = Math.abs(ratio);
  const sum = ratio < 0 ? distance : 0.6 * distance;
  return [(sum * size) / (1 + size), sum / (1 + size)];
}

/** Numbers of teeth of two wheels whose ratio is nearest to that of the radii. */
export function teeth([a, b]: readonly [number, number]): [number, number] {
  const least = Math.min(a, b);
  let best: [number, number] = [12, 12];
  let error = Infinity;
  for (let n = 12; n <= 24; ++n) {
    const other = Math.round((n * Math.max(a, b)) / least);
    const off = Math.abs(other / n - Math.max(a, b) / least);
    if (off < error - 1e-9) [best, error] = [a <= b ? [n, other] : [other, n], off];
  }
  return best;
}

/** Points at the rims of all wheels, for the poses of the bodies. */
export function rims(scene: Scene, poses: readonly Matrix4[]): Vector3[] {
  return gearings(scene).flatMap((gearing) => {
    const { predecessor, S_prev } = scene.bodies[gearing.a];
    const x = across(scene, gearing);
    const size = radii(gearing.turns, x.length());
    const y = new Vector3().crossVectors(axisOf(S_prev), x).normalize();
    const centres = [pointOf(S_prev), pointOf(S_prev).add(x)];
    x.normalize();
    return centres.flatMap((centre, k) =>
      [x, y].flatMap((e) => [-1, 1].map((side) => centre.clone().addScaledVector(e, side * size[k]).applyMatrix4(poses[predecessor]))),
    );
  });
}

/** A solid of constant thickness about z = 0 between an outer and an inner outline, which have as many points. */
function slab(outer: readonly [number, number][], inner: readonly [number, number][], thickness: number): BufferGeometry {
  const points: number[] = [];
  const h = thickness / 2;
  const quad = (...corners: [number, number, number][]) => [0, 1, 2, 0, 2, 3].forEach((k) => points.push(...corners[k]));
  outer.forEach((p, k) => {
    const next = (k + 1) % outer.length;
    const [q, r, s] = [outer[next], inner[next], inner[k]];
    quad([...p, -h], [...q, -h], [...q, h], [...p, h]);
    quad([...r, -h], [...s, -h], [...s, h], [...r, h]);
    quad([...p, h], [...q, h], [...r, h], [...s, h]);
    quad([...s, -h], [...r, -h], [...q, -h], [...p, -h]);
  });
  const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
  geometry.computeVertexNormals();
  return geometry;
}

/** The radius of the bore of a wheel, as a part of the radius of the wheel. */
const BORE = 0.05;

/** A wheel about z with a bore, whose first tooth (or else the gap after it) is in the direction of an angle. */
function wheel(radius: number, count: number, depth: number, thickness: number, at: number, gap: boolean): BufferGeometry {
  const outer: [number, number][] = [];
  const inner: [number, number][] = [];
  for (let k = 0; k < count; ++k) {
    for (const [along, out] of [[-0.3, -1], [-0.14, 1], [0.14, 1], [0.3, -1]]) {
      const angle = at + ((k + along + (gap ? 0.5 : 0)) * 2 * Math.PI) / count;
      const [c, s] = [Math.cos(angle), Math.sin(angle)];
      outer.push([(radius + out * depth) * c, (radius + out * depth) * s]);
      inner.push([BORE * radius * c, BORE * radius * s]);
    }
  }
  return slab(outer, inner, thickness);
}

/** A belt in the plane of x and y: about a wheel at the origin and one on the x-axis. */
function belt([a, b]: readonly [number, number], distance: number, thickness: number, height: number): BufferGeometry {
  const turn = Math.acos((a - b) / distance); // where the belt leaves both wheels
  const outline = (more: number) => {
    const arc = (x: number, r: number, from: number, to: number) =>
      Array.from({ length: 25 }, (_, k): [number, number] => {
        const angle = from + ((to - from) * k) / 24;
        return [x + (r + more) * Math.cos(angle), (r + more) * Math.sin(angle)];
      });
    return [...arc(0, a, turn, 2 * Math.PI - turn), ...arc(distance, b, -turn, turn)];
  };
  return slab(outline(thickness), outline(0), height);
}

/** How far wheels are beside the points of their joints, in units of symbols. */
const BESIDE = 0.5;

/** Couplings of hinges as toothed wheels, or as wheels with a belt. */
export function couplings({ scene, state, stage }: View): Layer | null {
  const all = gearings(scene);
  if (all.length === 0) return null;
  const material = new MeshStandardMaterial({ roughness: 0.55, metalness: 0.1 });
  const parts: Instances[] = [];
  const root = new Group();
  const add = (geometry: BufferGeometry, body: number, pose: Matrix4, color: string) => {
    const part = new Instances(geometry, material, [{ body, pose, color }]);
    const edges = edgesOf(part);
    part.castShadow = true;
    parts.push(part);
    root.add(part, ...(edges ? [edges] : []));
  };
  for (const gearing of all) {
    const [one, other] = [gearing.a, gearing.b].map((i) => scene.bodies[i]);
    const apart = across(scene, gearing);
    const distance = apart.length();
    const z = axisOf(one.S_prev);
    const x = apart.divideScalar(distance);
    const size = radii(gearing.turns, distance);
    const counts = teeth(size);
    const thickness = Math.min(0.3 * stage.unit, 0.15 * distance);
    const depth = gearing.turns < 0 ? (1.6 * size[0]) / counts[0] : 0.03 * Math.min(...size);
    const plane = new Matrix4().makeBasis(x, new Vector3().crossVectors(z, x), z).setPosition(pointOf(one.S_prev).addScaledVector(z, BESIDE * stage.unit));
    [one, other].forEach((body, k) => {
      const shape = wheel(size[k], counts[k], depth, thickness, k * Math.PI, k === 1 && gearing.turns < 0);
      const place = plane.clone().multiply(new Matrix4().makeTranslation(k * distance, 0, 0));
      const back = new Matrix4().makeRotationZ(k === 1 ? -gearing.offset : 0); // first tooth against first gap
      const onBody = matrixOf(body.S_self).multiply(back).multiply(matrixOf(body.S_prev).invert()).multiply(place);
      add(shape, [gearing.a, gearing.b][k], onBody, colorOfBody([gearing.a, gearing.b][k]));
    });
    if (gearing.turns > 0) add(belt(size, distance, 0.25 * thickness, 0.8 * thickness), one.predecessor, plane, colors.belt);
  }
  return {
    id: "couplings",
    title: "Couplings",
    hint: () => "wheels with teeth turn against each other, those in a belt alike",
    swatch: colors.coupled,
    on: true,
    root,
    update: () => parts.forEach((part) => part.place(state.tree.poses, 1)),
  };
}
