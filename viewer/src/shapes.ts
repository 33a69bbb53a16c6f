import {
  Box3,
  BoxGeometry,
  CylinderGeometry,
  DoubleSide,
  FrontSide,
  Group,
  IcosahedronGeometry,
  InstancedMesh,
  Matrix4,
  MeshLambertMaterial,
  MeshStandardMaterial,
  SphereGeometry,
  Vector3,
  type BufferGeometry,
  type Material,
} from "three";
import { ConvexGeometry } from "three/addons/geometries/ConvexGeometry.js";
import { mergeVertices } from "three/addons/utils/BufferGeometryUtils.js";
import { rims } from "./couplings";
import { edgesOf } from "./edges";
import { helix, rod, together } from "./glyphs";
import { Instances, type Item } from "./instances";
import { matrixOf, placeOfJoint } from "./kinematics";
import type { Part } from "./meshes";
import { colorOfBody, colors } from "./palette";
import { drawsOnProcessor, MANY, MOVING, RESTING } from "./processor";
import type { Scene, Shape } from "./scene";

/** Geometries of size 1; round ones have `sides` sides. */
function solids(sides: number) {
  return {
    box: new BoxGeometry(1, 1, 1),
    sphere: new SphereGeometry(1, sides, sides / 2).rotateX(Math.PI / 2),
    /** The half of a ball where z > 0. */
    dome: new SphereGeometry(1, sides, sides / 4, 0, 2 * Math.PI, 0, Math.PI / 2).rotateX(Math.PI / 2),
    cylinder: new CylinderGeometry(1, 1, 1, sides).rotateX(Math.PI / 2),
    tube: new CylinderGeometry(1, 1, 1, sides, 1, true).rotateX(Math.PI / 2),
  };
}
const fine = solids(40);
const coarse = solids(16);
const coarsest = solids(8);

/** The geometries for a number of shapes, chosen such that a frame does not take too long. */
function solidsFor(count: number): typeof fine {
  return count <= MANY ? fine : drawsOnProcessor() ? coarsest : coarse;
}

/** Length of the square that is drawn of a plane, m. */
const PLANE = 10;

const hulls = new WeakMap<Shape, BufferGeometry>();

/** The convex hull of balls about points, with the normals of the balls, so that its edges look round. */
function hull(shape: Shape): BufferGeometry {
  const known = hulls.get(shape);
  if (known) return known;
  const sphere = new IcosahedronGeometry(shape.radius, 2).deleteAttribute("normal").deleteAttribute("uv");
  const ball = mergeVertices(sphere).getAttribute("position"); // each corner once
  const centres = shape.points.map((point) => new Vector3(...point));
  const geometry = new ConvexGeometry(
    centres.flatMap((centre) => Array.from({ length: ball.count }, (_, k) => new Vector3().fromBufferAttribute(ball, k).add(centre))),
  );
  const position = geometry.getAttribute("position");
  const normal = geometry.getAttribute("normal");
  const corner = new Vector3();
  for (let k = 0; k < position.count; ++k) {
    corner.fromBufferAttribute(position, k);
    const centre = centres.reduce((a, b) => (b.distanceTo(corner) < a.distanceTo(corner) ? b : a));
    corner.sub(centre).normalize();
    normal.setXYZ(k, corner.x, corner.y, corner.z);
  }
  hulls.set(shape, geometry);
  return geometry;
}

const threads = new WeakMap<Shape, BufferGeometry>();

/** A rod about z with a thread. */
function thread(shape: Shape): BufferGeometry {
  const known = threads.get(shape);
  if (known) return known;
  const { radius: r, length: l, lead } = shape;
  const tube = Math.min(0.22 * r, 0.3 * Math.abs(lead));
  const geometry = together(rod(r - tube, -l / 2, l / 2, 20), helix(r - tube, lead, l / Math.abs(lead), tube, 20));
  threads.set(shape, geometry);
  return geometry;
}

/** The parts of which a shape is drawn: geometries of size 1, scaled and moved. */
function pieces(shape: Shape, meshes: readonly Part[][], solid: typeof fine): { geometry: BufferGeometry; material: Material | null; local: Matrix4 }[] {
  const { box, sphere, dome, cylinder, tube } = solid;
  const scaled = (geometry: BufferGeometry, x: number, y: number, z: number, height = 0) => ({
    geometry,
    material: null,
    local: new Matrix4().makeScale(x, y, z).setPosition(0, 0, height),
  });
  const { radius: r, length: l } = shape;
  switch (shape.kind) {
    case "box":
      return [scaled(box, ...shape.size)];
    case "sphere":
      return [scaled(sphere, r, r, r)];
    case "ellipsoid":
      return [scaled(sphere, ...shape.size)];
    case "cylinder":
      return [scaled(cylinder, r, r, l)];
    case "capsule":
      return [scaled(tube, r, r, l), scaled(dome, r, r, r, l / 2), scaled(dome, r, -r, -r, -l / 2)];
    case "hull":
      return [scaled(hull(shape), 1, 1, 1)];
    case "thread":
      return [scaled(thread(shape), 1, 1, 1)];
    case "socket":
      return [scaled(dome, r, r, r)];
    case "plane":
      return [scaled(box, PLANE, PLANE, PLANE / 1000, -PLANE / 2000)];
    case "mesh":
      return (meshes[shape.mesh] ?? []).map(({ geometry, material, pose }) => ({
        geometry,
        material,
        local: new Matrix4().makeScale(...shape.scale).multiply(pose),
      }));
  }
}

/** A material without gloss, if a processor draws, because gloss would take a third of the time for a frame. */
function material(opacity: number, collision: boolean, mesh: boolean): MeshStandardMaterial | MeshLambertMaterial {
  const seen = {
    opacity,
    transparent: opacity < 1,
    depthWrite: opacity === 1,
    side: mesh ? DoubleSide : FrontSide,
    wireframe: collision,
  };
  return drawsOnProcessor() ? new MeshLambertMaterial(seen) : new MeshStandardMaterial({ ...seen, roughness: 0.62, metalness: 0.05 });
}

/** Draws things in a simpler form while the scene moves. */
function simplerWhileMoving(things: Instances, geometry: BufferGeometry): InstancedMesh {
  const simpler = new InstancedMesh(geometry, things.material, things.items.length);
  simpler.instanceMatrix = things.instanceMatrix;
  simpler.instanceColor = things.instanceColor;
  simpler.frustumCulled = false;
  simpler.layers.set(MOVING);
  things.layers.set(RESTING);
  return simpler;
}

/** The shapes of one layer, with edges if one cannot see through them. Shapes of the same appearance are drawn together. */
export function shapeGroup(scene: Scene, shapes: readonly Shape[], meshes: readonly Part[][]): Group {
  const depth = scene.bodies.map(() => 0);
  scene.bodies.forEach((body, i) => i > 0 && (depth[i] = depth[body.predecessor] + 1));
  const gathered = new Map<string, { geometry: BufferGeometry; simpler: BufferGeometry; material: Material; items: Item[] }>();
  const solid = solidsFor(shapes.length);
  const simple = drawsOnProcessor() && solid === fine ? coarse : solid;
  for (const shape of shapes) {
    const collision = shape.role === "collision";
    const opacity = collision ? 0.5 : (shape.color?.[3] ?? 1);
    const pose = matrixOf(shape.pose);
    if (shape.stand_in) apart(pose, depth[shape.body]);
    const simpler = pieces(shape, meshes, simple);
    for (const [k, piece] of pieces(shape, meshes, solid).entries()) {
      const own = shape.color || collision ? null : piece.material;
      const key = `${piece.geometry.uuid} ${shape.kind} ${opacity} ${own?.uuid ?? ""}`;
      const made = gathered.get(key) ?? {
        geometry: piece.geometry,
        simpler: simpler[k].geometry,
        material: own ?? material(opacity, collision, shape.kind === "mesh" || shape.kind === "socket"),
        items: [],
      };
      gathered.set(key, made);
      made.items.push({
        body: shape.body,
        pose: pose.clone().multiply(piece.local),
        color: own ? "#ffffff" : collision ? colors.collision : shape.color ? rgb(shape.color) : colorOfBody(shape.body),
      });
    }
  }
  const group = new Group();
  for (const { geometry, simpler, material, items } of gathered.values()) {
    const drawn = new Instances(geometry, material, items);
    drawn.castShadow = !material.transparent;
    group.add(drawn);
    if (simpler !== geometry) group.add(simplerWhileMoving(drawn, simpler));
    const isSolid = !material.transparent && !(material as MeshStandardMaterial).wireframe;
    const edges = isSolid ? edgesOf(drawn) : null;
    if (edges) group.add(edges);
  }
  return group;
}

/**
 * Changes the sizes of balls a little. Stand-ins may have several balls at one place, one for each axis,
 * which would flicker if they had the same size.
 */
function apart(pose: Matrix4, depth: number): void {
  const size = 1 + 0.006 * (depth % 5);
  pose.scale(new Vector3(size, size, size));
}

function rgb(color: readonly number[]): string {
  return `rgb(${color.slice(0, 3).map((part) => Math.round(255 * Math.min(1, Math.max(0, part)))).join(",")})`;
}

/** The point of a plane, the plane z = 0 of a pose, that is nearest to a point. */
function footOn(plane: Matrix4, point: Vector3): Vector3 {
  const normal = new Vector3().setFromMatrixColumn(plane, 2);
  const height = point.clone().sub(new Vector3().setFromMatrixPosition(plane)).dot(normal);
  return point.clone().addScaledVector(normal, -height);
}

/**
 * The extent of the scene at these poses: points at the ends of its shapes, its joints and centres of mass. The origin of a
 * body does not count, since it may be far from the body, and a plane, which has no end, counts by its point nearest to them.
 */
export function reach(scene: Scene, poses: readonly Matrix4[], meshes: readonly Part[][]): Vector3[] {
  const points: Vector3[] = [];
  const planes: Matrix4[] = [];
  const corner = new Vector3();
  for (const shape of scene.shapes) {
    const pose = poses[shape.body].clone().multiply(matrixOf(shape.pose));
    if (shape.kind === "plane") {
      planes.push(pose);
      continue;
    }
    for (const { geometry, local } of pieces(shape, meshes, coarse)) {
      if (!geometry.boundingBox) geometry.computeBoundingBox();
      const { min, max } = geometry.boundingBox!;
      const placed = pose.clone().multiply(local);
      for (let k = 0; k < 8; ++k) {
        corner.set(k & 1 ? max.x : min.x, k & 2 ? max.y : min.y, k & 4 ? max.z : min.z);
        points.push(corner.clone().applyMatrix4(placed));
      }
    }
  }
  scene.bodies.forEach((body, i) => {
    if (i === 0) return;
    if (body.mass > 0) points.push(new Vector3(...body.com).applyMatrix4(poses[i]));
    points.push(placeOfJoint(body).applyMatrix4(poses[i]));
  });
  for (const { ends } of scene.lines ?? []) {
    for (const { body, point } of ends) points.push(new Vector3(...point).applyMatrix4(poses[body]));
  }
  for (const frame of scene.frames) {
    points.push(new Vector3().setFromMatrixPosition(poses[frame.body].clone().multiply(matrixOf(frame.pose))));
  }
  points.push(...rims(scene, poses));
  const middle = new Box3().setFromPoints(points).getCenter(new Vector3());
  for (const plane of planes) points.push(footOn(plane, middle));
  return points;
}
