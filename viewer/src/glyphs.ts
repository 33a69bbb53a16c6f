import {
  BoxGeometry,
  BufferAttribute,
  BufferGeometry,
  Color,
  ConeGeometry,
  CylinderGeometry,
  Matrix4,
  SphereGeometry,
  TorusGeometry,
} from "three";
import { mergeGeometries } from "three/addons/utils/BufferGeometryUtils.js";
import { colors } from "./palette";

/**
 * Symbols of about one unit in size. The axis of a symbol is z. A ring has `sides` sides, and thinner parts
 * have fewer.
 */

function painted(geometry: BufferGeometry, color: string): BufferGeometry {
  const { r, g, b } = new Color(color);
  const n = geometry.getAttribute("position").count;
  const values = new Float32Array(3 * n);
  for (let k = 0; k < n; ++k) values.set([r, g, b], 3 * k);
  return geometry.setAttribute("color", new BufferAttribute(values, 3));
}

/** A cylinder along z, from z = from to z = to. */
export function rod(radius: number, from: number, to: number, sides = 12): BufferGeometry {
  return new CylinderGeometry(radius, radius, to - from, sides).rotateX(Math.PI / 2).translate(0, 0, (from + to) / 2);
}

/** A cone along z whose tip is at z = tip. */
export function cone(radius: number, length: number, tip: number, sides = 16): BufferGeometry {
  return new ConeGeometry(radius, length, sides).rotateX(Math.PI / 2).translate(0, 0, tip - length / 2);
}

/** A part of the number of sides of a ring, for thinner things. */
function part(sides: number, of: number): number {
  return Math.max(3, Math.round(of * sides));
}

const alongX = new Matrix4().makeRotationY(Math.PI / 2);
const alongY = new Matrix4().makeRotationX(-Math.PI / 2);

/** Three arrows in red, green and blue, as long as the unit. */
export function triad(sides: number): BufferGeometry {
  const arrow = () => mergeGeometries([rod(0.03, 0, 0.8, part(sides, 0.2)), cone(0.085, 0.24, 1, part(sides, 0.4))]);
  return mergeGeometries([
    painted(arrow().applyMatrix4(alongX), colors.x),
    painted(arrow().applyMatrix4(alongY), colors.y),
    painted(arrow(), colors.z),
  ]);
}

/**
 * A tube along a helix about z that rises by `lead` in each turn, from z = -height/2 on. A negative lead
 * winds to the left.
 */
export function helix(radius: number, lead: number, turns: number, tube: number, sides = 28): BufferGeometry {
  const along = Math.max(2, Math.ceil(turns * sides));
  const around = 6;
  const handed = lead < 0 ? -1 : 1;
  const h = Math.abs(lead) / (2 * Math.PI);
  const length = Math.hypot(radius, h);
  const points: number[] = [];
  const normals: number[] = [];
  const faces: number[] = [];
  for (let i = 0; i <= along; ++i) {
    const angle = (2 * Math.PI * turns * i) / along;
    const [c, s] = [Math.cos(handed * angle), Math.sin(handed * angle)];
    const binormal = [(h * s * handed) / length, (-h * c * handed) / length, radius / length];
    for (let j = 0; j < around; ++j) {
      const [cj, sj] = [Math.cos((2 * Math.PI * j) / around), Math.sin((2 * Math.PI * j) / around)];
      const n = [c * cj + binormal[0] * sj, s * cj + binormal[1] * sj, binormal[2] * sj];
      normals.push(...n);
      points.push(radius * c + tube * n[0], radius * s + tube * n[1], h * (angle - Math.PI * turns) + tube * n[2]);
    }
  }
  for (let i = 0; i < along; ++i) {
    for (let j = 0; j < around; ++j) {
      const [a, b] = [i * around + j, i * around + ((j + 1) % around)];
      faces.push(a, b, a + around, b, b + around, a + around);
    }
  }
  return new BufferGeometry()
    .setAttribute("position", new BufferAttribute(new Float32Array(points), 3))
    .setAttribute("normal", new BufferAttribute(new Float32Array(normals), 3))
    .setIndex(faces);
}

/** Merges geometries of three.js and geometries of this file. */
export function together(...parts: BufferGeometry[]): BufferGeometry {
  return mergeGeometries(
    parts.map((part) => {
      const bare = part.index ? part.toNonIndexed() : part;
      bare.deleteAttribute("uv");
      return bare;
    }),
  );
}

/** An axis with a head, from z = -1.1 to 1.35. */
function axis(sides: number): BufferGeometry[] {
  return [rod(0.035, -1.1, 1.1, part(sides, 0.3)), cone(0.1, 0.28, 1.35, part(sides, 0.4))];
}

function ring(radius: number, tube: number, sides: number, angle?: number): BufferGeometry {
  return new TorusGeometry(radius, tube, part(sides, 0.2), sides, angle);
}

/** An axis with a head, and a ring whose head shows the positive direction. */
export function hinge(sides: number): BufferGeometry {
  const turn = 1.6 * Math.PI;
  const head = cone(0.13, 0.32, 0.2, part(sides, 0.4)).rotateX(-Math.PI / 2).translate(0.62, 0, 0).rotateZ(turn);
  return together(...axis(sides), ring(0.62, 0.04, sides, turn), head);
}

/** A screw: an axis, and a thread about it. */
export function screwThread(sides: number, lead: number): BufferGeometry {
  const turns = 1.5 / Math.abs(lead);
  return together(...axis(sides), helix(0.42, lead, turns, 0.05, part(sides, 0.7)));
}

/** Arrows both ways along a rail, the positive one larger. */
export function slider(sides: number): BufferGeometry {
  const rail = (x: number) => new BoxGeometry(0.07, 0.24, 1.5).translate(x, 0, 0);
  const head = (radius: number, length: number, tip: number) => cone(radius, length, tip, part(sides, 0.4));
  const back = head(0.08, 0.2, 0.2).rotateX(Math.PI).translate(0, 0, -1.2);
  return together(rod(0.035, -1.2, 1.2, part(sides, 0.3)), head(0.13, 0.34, 1.45), back, rail(0.2), rail(-0.2));
}

export function ball(sides: number): BufferGeometry {
  return together(new SphereGeometry(0.34, part(sides, 0.6), part(sides, 0.4)), ring(0.52, 0.035, sides));
}

/** A thin plate with its normal. */
export function plate(sides: number): BufferGeometry {
  return together(new BoxGeometry(1.5, 1.5, 0.05), rod(0.035, 0, 0.8, part(sides, 0.3)), cone(0.1, 0.28, 1.05, part(sides, 0.4)));
}

/** The symbol of a centre of mass: a ball whose eighths are black and white in turn. */
export function quarteredBall(sides: number): BufferGeometry {
  const sphere = new SphereGeometry(1, 4 * part(sides, 0.2), 2 * part(sides, 0.3)).toNonIndexed();
  const position = sphere.getAttribute("position");
  const values = new Float32Array(3 * position.count);
  for (let face = 0; face < position.count; face += 3) {
    const middle = (f: "getX" | "getY" | "getZ") => position[f](face) + position[f](face + 1) + position[f](face + 2);
    const light = middle("getX") * middle("getY") * middle("getZ") > 0 ? 1 : 0.03;
    values.fill(light, 3 * face, 3 * face + 9);
  }
  return sphere.setAttribute("color", new BufferAttribute(values, 3));
}
