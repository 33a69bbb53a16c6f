import { BufferGeometry, CylinderGeometry, Group, Matrix4, MeshStandardMaterial, Vector3 } from "three";
import { mergeGeometries } from "three/addons/utils/BufferGeometryUtils.js";
import { along } from "./axode";
import { helix, rod } from "./glyphs";
import { Instances, type Item } from "./instances";
import type { Layer, View } from "./layers";
import { colors } from "./palette";
import type { Line } from "./scene";

/**
 * A coil from z = 0 to z = 1 whose radius is one. Its wire is round
 * if the coil is drawn `slender` times as long as its radius.
 */
function coil(slender: number): BufferGeometry {
  const turns = Math.round(Math.min(24, Math.max(5, slender / 1.6)));
  const wire = helix(1, (0.8 * slender) / turns, turns, 0.18, 16).scale(1, 1, 1 / slender);
  wire.translate(0, 0, 0.5).deleteAttribute("normal");
  const ends = [rod(0.18, 0, 0.1, 8), rod(0.18, 0.9, 1, 8)].map(bare);
  const whole = mergeGeometries([wire.toNonIndexed(), ...ends]);
  whole.computeVertexNormals();
  return whole;
}

/** A cylinder with a piston in it, from z = 0 to z = 1. */
function piston(): BufferGeometry {
  const housing = new CylinderGeometry(0.8, 0.8, 0.5, 16).rotateX(Math.PI / 2).translate(0, 0, 0.4);
  const whole = mergeGeometries([bare(housing), bare(rod(0.16, 0, 0.2, 8)), bare(rod(0.35, 0.4, 1, 10))]);
  whole.computeVertexNormals();
  return whole;
}

function bare(geometry: BufferGeometry): BufferGeometry {
  const points = geometry.toNonIndexed();
  points.deleteAttribute("uv");
  points.deleteAttribute("normal");
  return points;
}

/** Radius of a coil, in units of symbols. */
const RADIUS = 0.4;

/**
 * What acts between two points: springs are coils, dampers
 * are pistons (in a coil, if both), and drives are cylinders.
 */
export function springs({ scene, state, stage }: View): Layer | null {
  const lines = scene.lines ?? [];
  if (lines.length === 0) return null;
  const material = new MeshStandardMaterial({ roughness: 0.45, metalness: 0.2 });
  const items = (which: (line: Line) => boolean): { line: Line; item: Item }[] =>
    lines.filter(which).map((line) => ({ line, item: { body: 0, pose: new Matrix4(), color: line.driven ? colors.driven : colors.spring } }));
  const coils = items(({ stiffness }) => stiffness !== 0);
  const pistons = items(({ damping }) => damping !== 0);
  const cylinders = items(({ driven }) => driven);
  const width = ({ rest }: Line, length: number, radius: number) => Math.min(radius * stage.unit, 0.2 * (rest || length));
  const lengthOf = (line: Line) => {
    const [a, b] = line.ends.map(({ body, point }) => new Vector3(...point).applyMatrix4(state.tree.poses[body]));
    return b.sub(a).length();
  };
  const slender = coils.length > 0 ? lengthOf(coils[0].line) / width(coils[0].line, lengthOf(coils[0].line), RADIUS) : 0;
  const parts = [
    { entries: coils, drawn: new Instances(coil(slender), material, coils.map(({ item }) => item)), radius: RADIUS },
    { entries: pistons, drawn: new Instances(piston(), material, pistons.map(({ item }) => item)), radius: 0.2 },
    { entries: cylinders, drawn: new Instances(piston(), material, cylinders.map(({ item }) => item)), radius: 0.35 },
  ].filter(({ entries }) => entries.length > 0);
  const root = new Group();
  for (const { drawn } of parts) {
    drawn.castShadow = true;
    root.add(drawn);
  }
  const update = () => {
    for (const { entries, drawn, radius } of parts) {
      for (const { line, item } of entries) {
        const [a, b] = line.ends.map(({ body, point }) => new Vector3(...point).applyMatrix4(state.tree.poses[body]));
        const e = b.clone().sub(a);
        const length = e.length();
        const wide = width(line, length, radius);
        item.pose = length > 0 ? along({ centre: a, e: e.divideScalar(length) }).scale(new Vector3(wide, wide, length)) : new Matrix4().makeScale(0, 0, 0);
      }
      drawn.place(state.tree.poses, 1);
    }
  };
  return { id: "springs", title: "Springs", hint: () => "coils; pistons are dampers and drives", swatch: colors.spring, on: true, root, update };
}
