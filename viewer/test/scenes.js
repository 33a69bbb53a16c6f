import { apply, cross, dot, exp, identity, inverse, JOINTS, matrixOf, poseOf, poses, times, turn, twists } from "./reference.js";

/**
 * Scenes for the tests. Everything is drawn at zero in the
 * inertial frame, from which poses and joint frames follow.
 */

/** A frame at a point whose z-axis points along a direction. */
export function frameAt(point, direction = [0, 0, 1]) {
  const length = Math.hypot(...direction);
  const z = direction.map((x) => x / length);
  const w = cross([0, 0, 1], z);
  const s = Math.hypot(...w);
  const angle = Math.atan2(s, z[2]);
  const R = s > 1e-12 ? exp([...w.map((x) => (x * angle) / s), 0, 0, 0]) : exp([z[2] < 0 ? Math.PI : 0, 0, 0, 0, 0, 0]);
  return R.map((row, i) => (i < 3 ? [...row.slice(0, 3), point[i]] : row));
}

export class SceneBuilder {
  constructor(name, gravity = [0, 0, -9.81]) {
    this.scene = {
      format: "axode scene 1", name, gravity, nq: 0, nv: 0, bodies: [{ name: "ground" }], frames: [], shapes: [],
      meshes: [], loops: [], q: [], warnings: [], motion: null, coordinate_names: [], velocity_names: [],
    };
    this.reference = [identity()];
  }

  /** A body whose frame is drawn at A, moved by a joint whose frame is drawn at F. Returns its index. */
  body(name, predecessor, kind, F, { A = F, mass = 1, com = [0, 0, 0], inertia = [0.01, 0.01, 0.01, 0, 0, 0], joint = `${name} joint`, pitch = 0, limits, leader = null, passive = false } = {}) {
    const { scene } = this;
    const { rest } = JOINTS[kind];
    const [nq, nv] = leader ? [0, 0] : [rest.length, JOINTS[kind].nv];
    scene.bodies.push({
      name, predecessor, mass, com, inertia,
      S_prev: poseOf(times(inverse(this.reference[predecessor]), F)),
      S_self: poseOf(times(inverse(A), F)),
      A: poseOf(A),
      joint: { name: joint, kind, pitch, iq: scene.nq, nq, iv: scene.nv, nv, leader, limits: limits ?? Array(JOINTS[kind].nv).fill([null, null]), passive },
    });
    this.reference.push(A);
    if (!leader) scene.q.push(...rest);
    scene.nq += nq;
    scene.nv += nv;
    for (let k = 0; k < nq; ++k) scene.coordinate_names.push(nq === 1 ? joint : `${joint}[${k}]`);
    for (let k = 0; k < nv; ++k) scene.velocity_names.push(nv === 1 ? joint : `${joint}[${k}]`);
    return scene.bodies.length - 1;
  }

  shape(body, kind, sizes, { at = identity(), role = "visual", color = null, stand_in = false } = {}) {
    this.scene.shapes.push({
      body, kind, role, name: "", pose: poseOf(at), size: [1, 1, 1], radius: 0, length: 0, scale: [1, 1, 1], mesh: 0, color, stand_in, ...sizes,
    });
  }

  /**
   * Fills in the motion q(t), which the scene's joints have
   * to be able to follow: those with one coordinate, or free.
   */
  move(q, until, count, mass = false) {
    const { scene } = this;
    const t = Array.from({ length: count }, (_, k) => (until * k) / (count - 1));
    const d = 1e-5;
    const V = t.map((time) => twists(poses(scene, q(time - d)), poses(scene, q(time + d)), 2 * d));
    const momenta = t.map((time, k) => {
      const C = poses(scene, q(time));
      return scene.bodies.slice(1).map((body, i) => momentum(body, C[i + 1], V[k][i]));
    });
    const total = momenta.map((bodies) => bodies.reduce((sum, p) => sum.map((x, k) => x + p[k])));
    scene.motion = {
      t,
      q: t.map(q),
      v: t.map((time) => {
        const [a, b] = [q(time - d), q(time + d)];
        const now = q(time);
        return scene.bodies.slice(1).flatMap(({ joint: { kind, iq, nq } }) => {
          const rate = b.slice(iq, iq + nq).map((x, k) => (x - a[iq + k]) / (2 * d));
          return kind === "spherical" ? angularVelocity(now.slice(iq, iq + 4), rate) : rate;
        });
      }),
      tau: t.map((time) => scene.velocity_names.map((_, k) => Math.sin(time + k))),
      series: [
        { name: "energy", unit: "J", labels: ["kinetic"], values: momenta.map((p, k) => [p.reduce((T, x, i) => T + 0.5 * dot(x, V[k][i]), 0)]) },
        { name: "momentum", unit: "N m s, N s", labels: ["Lx", "Ly", "Lz", "px", "py", "pz"], values: total },
      ],
      twists: V,
      wrenches: momenta.map((bodies) => bodies.map((p) => p.map((x) => 5 * x))),
      momenta,
    };
    scene.q = q(0);
    return this;
  }
}

/** 2 q* q' of a quaternion x y z w. */
function angularVelocity([x, y, z, w], [dx, dy, dz, dw]) {
  return [w * dx - x * dw - y * dz + z * dy, w * dy - y * dw - z * dx + x * dz, w * dz - z * dw - x * dy + y * dx].map((r) => 2 * r);
}

/** Spatial momentum (angular; linear) of a body with pose C and spatial twist V. */
function momentum({ mass, com, inertia: [xx, yy, zz, xy, xz, yz] }, C, V) {
  const w = V.slice(0, 3);
  const c = apply(C, com);
  const rotation = cross(w, c);
  const p = V.slice(3).map((x, k) => mass * (x + rotation[k]));
  const wb = turn(inverse(C), w);
  const L = turn(C, [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]].map((row) => dot(row, wb)));
  const about = cross(c, p);
  return [...L.map((x, k) => x + about[k]), ...p];
}

/** An arm of n hinges about z and y in turn, of capsules. */
export function arm(n = 6) {
  const builder = new SceneBuilder("arm");
  builder.shape(0, "cylinder", { radius: 0.12, length: 0.1 }, { at: frameAt([0, 0, -0.05]), color: [0.35, 0.39, 0.44, 1] });
  let last = 0;
  let height = 0;
  for (let k = 0; k < n; ++k) {
    const length = k % 2 === 0 ? 0.2 : 0.3;
    const F = frameAt([0, 0, height], k % 2 === 0 ? [0, 0, 1] : [0, 1, 0]);
    last = builder.body(`link ${k + 1}`, last, "revolute", F, {
      A: frameAt([0, 0, height]), joint: `A${k + 1}`, mass: 4 - 0.5 * k, com: [0, 0.01, length / 2],
      inertia: [0.03, 0.03, 0.006, 0, 0, 0.002], limits: [[-2.9, 2.9]],
    });
    builder.shape(last, "capsule", { radius: 0.075 - 0.007 * k, length }, { at: frameAt([0, 0, length / 2]) });
    builder.shape(last, "box", { size: [0.2, 0.2, length] }, { at: frameAt([0, 0, length / 2]), role: "collision" });
    height += length;
  }
  builder.scene.frames.push({ name: "flange", body: last, pose: [0, 0, 0.3, 0, 0, 0, 1] });
  return builder;
}

export function movingArm() {
  return arm().move((t) => [0, 1, 2, 3, 4, 5].map((k) => (0.9 - 0.08 * k) * Math.sin((1 + 0.3 * k) * t + 0.4 * k)), 6, 121).scene;
}

/** A top that precesses steadily: its axodes are two cones with the same apex. */
export function top(tilt = 0.5, precession = 1.3, spin = 4) {
  const builder = new SceneBuilder("top");
  const body = builder.body("top", 0, "spherical", identity(), { joint: "tip", mass: 0.5, com: [0, 0, 0.2], inertia: [0.002, 0.002, 0.0012, 0, 0, 0] });
  builder.shape(body, "cylinder", { radius: 0.012, length: 0.3 }, { at: frameAt([0, 0, 0.15]), color: [0.3, 0.33, 0.38, 1] });
  builder.shape(body, "cylinder", { radius: 0.1, length: 0.04 }, { at: frameAt([0, 0, 0.2]), color: [0.75, 0.32, 0.28, 1] });
  const q = (t) => poseOf(times(times(exp([0, 0, precession * t, 0, 0, 0]), exp([tilt, 0, 0, 0, 0, 0])), exp([0, 0, (spin * t) % (2 * Math.PI), 0, 0, 0]))).slice(3);
  return builder.move(q, 5, 201).scene;
}

/** A four-bar linkage in the plane of y and z: crank, coupler, rocker; its axodes are cylinders. */
export function fourBar(a = 0.3, b = 0.7, c = 0.6, d = 0.8) {
  const builder = new SceneBuilder("four-bar");
  const x = [1, 0, 0];
  const angles = (crank) => {
    const [Ay, Az] = [a * Math.cos(crank), a * Math.sin(crank)];
    const [dy, dz] = [d - Ay, -Az];
    const l = Math.hypot(dy, dz);
    const coupler = Math.atan2(dz, dy) + Math.acos((l * l + b * b - c * c) / (2 * l * b));
    const rocker = Math.atan2(Az + b * Math.sin(coupler), Ay + b * Math.cos(coupler) - d);
    return [crank, coupler - crank, rocker];
  };
  const bar = (name, from, point, length) => {
    const body = builder.body(name, from, "revolute", frameAt(point, x), { A: frameAt(point), com: [0, length / 2, 0], joint: name, passive: name !== "crank" });
    builder.shape(body, "hull", { radius: 0.02, points: [[0, 0, 0], [0, length, 0], [0.03, length / 2, 0]] });
    return body;
  };
  const crank = bar("crank", 0, [0, 0, 0], a);
  const coupler = bar("coupler", crank, [0, a, 0], b);
  const rocker = bar("rocker", 0, [0, d, 0], c);
  const upright = frameAt([0, 0, 0], x);
  const end = (length) => poseOf(upright.map((row, i) => (i === 1 ? [...row.slice(0, 3), length] : row)));
  builder.scene.loops.push({ name: "pin", kind: "revolute", ends: [{ body: coupler, pose: end(b) }, { body: rocker, pose: end(c) }] });
  return builder.move((t) => angles(1 + Math.PI * t), 2, 121).scene;
}

/** Every kind of joint, a coupled one, and frames that are nowhere at the origin. */
export function everyKind() {
  const builder = new SceneBuilder("every kind");
  const column = builder.body("column", 0, "prismatic", frameAt([0.1, 0.2, 0.3], [1, 2, 3]), { A: frameAt([0.3, -0.2, 0.1], [0, 1, 1]) });
  const screw = builder.body("screw", column, "helical", frameAt([0.4, 0.1, 0.2], [0, 1, 0.3]), { A: frameAt([0.2, 0.1, 0.9]), pitch: -0.03 });
  builder.body("nut", column, "prismatic", frameAt([0.4, 0.5, 0.2], [0, 1, 0.3]), { leader: { joint: screw, ratio: 0.03, offset: 0.1 } });
  const ball = builder.body("ball", screw, "spherical", frameAt([0.6, 0.2, 0.5], [1, 0, 0]), { A: frameAt([0.7, 0.1, 0.4], [1, 1, 0]) });
  builder.body("hinge", ball, "revolute", frameAt([0.8, 0.1, 0.4], [0, -1, 1]), { A: frameAt([0.8, 0.3, 0.4]), limits: [[-1, 2]], passive: true });
  builder.body("table", 0, "planar", frameAt([-0.4, 0, 0.1], [0.2, 0, 1]), { A: frameAt([-0.5, 0, 0.2]) });
  builder.body("drone", 0, "free", frameAt([-0.2, 0.6, 0.5], [0, 1, 1]), { A: frameAt([-0.2, 0.6, 0.6], [1, 1, 1]) });
  for (let i = 1; i < builder.scene.bodies.length; ++i) {
    builder.shape(i, "box", { size: [0.12, 0.08, 0.05] }, { stand_in: i % 2 === 0 });
  }
  builder.scene.loops.push({ name: "pin", kind: "revolute", ends: [{ body: 5, pose: [0, 0, 0, 0, 0, 0, 1] }, { body: 6, pose: [0.1, 0, 0, 0, 0, 0, 1] }] });
  return builder.scene;
}

/** n pendulums on a row, with several shapes each. */
export function many(n = 100) {
  const builder = new SceneBuilder("many");
  for (let k = 0; k < n; ++k) {
    const at = [0.3 * (k % 10), 0.3 * Math.floor(k / 10), 0];
    const body = builder.body(`p${k}`, 0, "revolute", frameAt(at, [0, 1, 0]), { A: frameAt(at), com: [0, 0, -0.2] });
    builder.shape(body, "capsule", { radius: 0.02, length: 0.2 }, { at: frameAt([0, 0, -0.1]) });
    builder.shape(body, "sphere", { radius: 0.05 }, { at: frameAt([0, 0, -0.22]), color: [0.2, 0.5, 0.7, 1] });
  }
  return builder.move((t) => Array.from({ length: n }, (_, k) => 0.8 * Math.sin(3 * t + 0.06 * k)), 4, 41).scene;
}

export { exp, matrixOf, poses };
