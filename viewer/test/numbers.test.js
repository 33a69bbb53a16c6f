/** Laws of what the page computes, apart from any browser. */
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { Matrix4, Quaternion, Vector3 } from "three";
import { createServer } from "vite";
import { apply, cross, dot, exp, inverse, matrixOf, poseOf, poses, times, turn } from "./reference.js";
import { everyKind, fourBar, frameAt, movingArm, SceneBuilder, top } from "./scenes.js";

const EPSILON = 1e-9;
const movedArm = movingArm();
const root = fileURLToPath(new URL("..", import.meta.url));
let server;
let kinematics, screws, axode, inertia, motion, history, sceneModule, labels, resolution, closure, ticks, vectors, stateModule;

before(async () => {
  server = await createServer({ root, configFile: false, logLevel: "error", server: { middlewareMode: true, hmr: false, ws: false, watch: null }, optimizeDeps: { noDiscovery: true } });
  const load = (name) => server.ssrLoadModule(`/src/${name}.ts`);
  [kinematics, screws, axode, inertia, motion, history, sceneModule, labels, resolution, closure, ticks, vectors, stateModule] = await Promise.all(
    ["kinematics", "screws", "axode", "inertia", "motion", "history", "scene", "labels", "resolution", "closure", "ticks", "vectors", "state"].map(load));
});
after(() => server?.close());

function near(actual, expected, tolerance = EPSILON, what = "") {
  const [a, b] = [[...actual].flat(), [...expected].flat()];
  assert.equal(a.length, b.length, what);
  const size = Math.max(1, ...b.map(Math.abs));
  a.forEach((x, k) => assert.ok(Math.abs(x - b[k]) <= tolerance * size, `${what} [${k}]: ${x}, expected ${b[k]}`));
}

const rows = (m) => [0, 1, 2, 3].map((i) => [0, 1, 2, 3].map((j) => m.elements[4 * j + i]));

/** A generator of numbers in (-1, 1) that is the same each time. */
function random(seed) {
  let state = seed;
  return () => {
    state = (1103515245 * state + 12345) % 2147483648;
    return state / 1073741824 - 1;
  };
}

function randomState(scene, next) {
  return scene.bodies.slice(1).flatMap(({ joint: { kind, nq } }) => {
    const q = Array.from({ length: nq }, next);
    if (kind === "spherical" || kind === "free") {
      const length = Math.hypot(...q.slice(0, 4));
      for (let k = 0; k < 4; ++k) q[k] /= length;
    }
    return q;
  });
}

test("poses are those of the product of exponentials, for every kind of joint", () => {
  const scene = everyKind();
  const next = random(7);
  const tree = new kinematics.Tree(scene.bodies);
  for (let k = 0; k < 20; ++k) {
    const q = randomState(scene, next);
    tree.update(q);
    poses(scene, q).forEach((C, i) => near(rows(tree.poses[i]), C, EPSILON, scene.bodies[i].name));
  }
});

test("rotation vectors and quaternions are inverses, also at no turn and at half a turn", () => {
  const next = random(3);
  for (let k = 0; k < 50; ++k) {
    const x = new Vector3(next(), next(), next()).setLength(k === 0 ? 0 : k === 1 ? Math.PI - 1e-9 : Math.PI * Math.abs(next()));
    const q = kinematics.expQuaternion(x);
    near(kinematics.logQuaternion(q).toArray(), x.toArray(), 1e-7);
    near(kinematics.logQuaternion(new Quaternion(-q.x, -q.y, -q.z, -q.w)).toArray(), x.toArray(), 1e-7);
  }
});

test("a twist is its pitch along, and its turning about, the screw axis", () => {
  const next = random(11);
  for (let k = 0; k < 20; ++k) {
    const [w, v] = [[next(), next(), next()], [next(), next(), next()]];
    const axis = screws.axisOf(screws.screwOf([...w, ...v]), 1e-9);
    const [e, p] = [axis.e.toArray(), axis.p.toArray()];
    near([dot(e, e), dot(e, p)], [1, 0]);
    const speed = Math.hypot(...w);
    near(e.map((x) => speed * x), w);
    near(cross(p, w).map((x, i) => x + axis.pitch * w[i]), v);
  }
  assert.equal(screws.axisOf(screws.screwOf([0, 0, 0, 1, 2, 3]), 1e-9), null);
});

test("power is the same in every representation", () => {
  const next = random(5);
  for (let k = 0; k < 20; ++k) {
    const [V, W] = [Array.from({ length: 6 }, next), Array.from({ length: 6 }, next)];
    const C = new Matrix4().compose(new Vector3(next(), next(), next()), new Quaternion(next(), next(), next(), next()).normalize(), new Vector3(1, 1, 1));
    for (const representation of Object.keys(screws.representations)) {
      const twist = screws.represent(screws.screwOf(V), false, C, representation);
      const wrench = screws.represent(screws.screwOf(W), true, C, representation);
      near([dot(twist, wrench)], [dot(V, W)], EPSILON, representation);
    }
  }
});

test("a body-fixed twist is Ad of the inverse pose of the spatial one", () => {
  const scene = movedArm;
  const V = scene.motion.twists[50][5];
  const C = poses(scene, scene.motion.q[50])[6];
  const numbers = screws.represent(screws.screwOf(V), false, new Matrix4().set(...C.flat()), "body");
  const r = [C[0][3], C[1][3], C[2][3]];
  const w = turn(inverse(C), V.slice(0, 3));
  const v = turn(inverse(C), V.slice(3).map((x, i) => x + cross(V.slice(0, 3), r)[i]));
  near(numbers, [...w, ...v]);
});

test("the first link of an arm turns about its joint, whose axis is both axodes", () => {
  const scene = movedArm;
  const { fixed, moving } = axode.axodes(scene, new history.History(scene), 1, 100);
  for (const g of [...fixed, ...moving].filter((x) => x !== null)) {
    near([Math.abs(g.e.z), g.centre.x, g.centre.y], [1, 0, 0], 1e-4);
  }
});

test("the fixed and the moving axode touch along the screw axis", () => {
  const scene = movedArm;
  const { fixed, moving } = axode.axodes(scene, new history.History(scene), 6, 100);
  assert.ok(fixed.filter((g) => g !== null).length > 100);
  fixed.forEach((g, k) => {
    if (g === null) return assert.equal(moving[k], null);
    const C = poses(scene, scene.motion.q[k])[6];
    near(apply(C, moving[k].centre.toArray()), g.centre.toArray());
    near(turn(C, moving[k].e.toArray()), g.e.toArray());
    const axis = screws.axisOf(screws.screwOf(scene.motion.twists[k][5]), 1e-9);
    near([Math.abs(dot(axis.e.toArray(), g.e.toArray())), screws.nearest(axis, g.centre).distanceTo(g.centre)], [1, 0], 1e-6);
  });
});

test("the axodes of a top that precesses steadily are cones about the vertical and about the top", () => {
  const [tilt, precession, spin] = [0.5, 1.3, 4];
  const scene = top(tilt, precession, spin);
  const { fixed, moving } = axode.axodes(scene, new history.History(scene), 1, 100);
  // w = precession e_z + spin e_top; its angles with both are the half angles of the cones.
  const w = Math.hypot(precession + spin * Math.cos(tilt), spin * Math.sin(tilt));
  const [aboutVertical, aboutTop] = [(precession + spin * Math.cos(tilt)) / w, (spin + precession * Math.cos(tilt)) / w];
  fixed.forEach((g, k) => {
    near([Math.abs(g.e.z), Math.abs(moving[k].e.z)], [aboutVertical, aboutTop], 1e-6);
    near([g.e.clone().cross(g.centre).length()], [0], 1e-6);
  });
});

test("the screw axis of a coupler passes through the pole where crank and rocker meet", () => {
  const scene = fourBar();
  const { fixed } = axode.axodes(scene, new history.History(scene), 2, 100);
  let met = 0;
  fixed.forEach((g, k) => {
    if (g === null) return;
    const C = poses(scene, scene.motion.q[k]);
    const lines = [1, 3].map((i) => ({ p: [C[i][1][3], C[i][2][3]], d: [C[i][1][1], C[i][2][1]] }));
    for (const { p, d } of lines) {
      near([(g.centre.y - p[0]) * d[1] - (g.centre.z - p[1]) * d[0]], [0], 1e-4);
      ++met;
    }
  });
  assert.ok(met > 200);
});

test("principal axes diagonalise an inertia, and its ellipsoid has that inertia", () => {
  const next = random(17);
  for (let k = 0; k < 20; ++k) {
    const [xx, yy, zz, xy, xz, yz] = k === 0 ? [1, 1, 1, 0, 0, 0] : [2 + next(), 2 + next(), 2 + next(), 0.3 * next(), 0.3 * next(), 0.3 * next()];
    const { moments, axes } = inertia.principalAxes([xx, yy, zz, xy, xz, yz]);
    assert.ok(axes.determinant() > 0.999999);
    const I = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    const e = rows(axes);
    for (let c = 0; c < 3; ++c) {
      const axis = [e[0][c], e[1][c], e[2][c]];
      near(I.map((row) => dot(row, axis)), axis.map((x) => x * moments.getComponent(c)));
    }
    const { x: a, y: b, z: c } = inertia.ellipsoid(3, moments);
    near([b * b + c * c, a * a + c * c, a * a + b * b].map((s) => (3 * s) / 5), moments.toArray());
  }
});

/** The poses of the joints of a scene, apart from the page. */
const jointPoses = (scene, q) => poses(scene, q).slice(1);

/** q a little later, where the joints go on with the velocities v: from poses and exponentials alone. */
function movedAlong(scene, q, v, t) {
  return scene.bodies.slice(1).flatMap(({ joint: { kind, iq, nq, iv, nv, leader } }) => {
    if (leader) return [];
    const [x, u] = [q.slice(iq, iq + nq), v.slice(iv, iv + nv).map((c) => c * t)];
    if (nv === 1) return [x[0] + u[0]];
    if (kind === "planar") {
      const C = times(matrixOf([x[1], x[2], 0, 0, 0, Math.sin(x[0] / 2), Math.cos(x[0] / 2)]), exp([0, 0, u[0], u[1], u[2], 0]));
      return [x[0] + u[0], C[0][3], C[1][3]];
    }
    const pose = poseOf(times(matrixOf([...(kind === "free" ? x.slice(4) : [0, 0, 0]), ...x.slice(0, 4)]), exp([...u, 0, 0, 0].slice(0, 6))));
    return kind === "free" ? [...pose.slice(3), ...pose.slice(0, 3)] : pose.slice(3);
  });
}

test("between samples joints go on with their velocities, however far they turn", () => {
  const scene = everyKind();
  const next = random(23);
  const q = randomState(scene, next);
  const v = Array.from({ length: scene.nv }, () => 9 * next());
  const t = [0, 0.9, 2.5];
  const samples = { t, q: t.map((time) => movedAlong(scene, q, v, time)), v: t.map(() => v) };
  for (const time of [-1, 0, 0.1, 0.45, 0.8999, 0.9, 1.3, 2.2, 2.5, 99]) {
    const found = motion.coordinatesAt(scene, samples, motion.momentOf(t, time));
    const exact = movedAlong(scene, q, v, Math.min(Math.max(time, 0), 2.5));
    jointPoses(scene, found).forEach((C, i) => near(C, jointPoses(scene, exact)[i], 1e-7, `${scene.bodies[i + 1].name} at ${time}`));
    scene.bodies.slice(1).forEach(({ joint: { kind, iq } }) => kind === "planar" && near([found[iq]], [exact[iq]], 1e-9));
  }
});

test("samples are met with the velocities that they have", () => {
  const scene = everyKind();
  const next = random(29);
  const t = [0, 0.3, 0.7];
  const samples = { t, q: t.map(() => randomState(scene, next)), v: t.map(() => Array.from({ length: scene.nv }, () => 4 * next())) };
  const d = 1e-5;
  [[0, 1], [1, -1], [1, 1], [2, -1]].forEach(([k, side]) => {
    const found = motion.coordinatesAt(scene, samples, motion.momentOf(t, t[k] + side * d));
    const exact = movedAlong(scene, samples.q[k], samples.v[k], side * d);
    jointPoses(scene, found).forEach((C, i) => near(C, jointPoses(scene, exact)[i], 1e-7, `${scene.bodies[i + 1].name} at sample ${k}`));
  });
});

test("between samples a fast top is where it is", () => {
  const exact = top(0.5, 1.3, 40);
  const { t, q, v } = exact.motion;
  const every = 4; // samples in which it turns by 4 rad
  const coarse = [t, q, v].map((rows) => rows.filter((_, k) => k % every === 0));
  const samples = { t: coarse[0], q: coarse[1], v: coarse[2] };
  t.forEach((time, k) => {
    const found = motion.coordinatesAt(exact, samples, motion.momentOf(samples.t, time));
    near(poses(exact, found)[1], poses(exact, q[k])[1], 0.05, `at ${time}`);
  });
});

test("what a scene lacks is said", () => {
  const broken = (change) => {
    const scene = structuredClone(movedArm);
    change(scene);
    return JSON.stringify(scene);
  };
  assert.throws(() => sceneModule.readScene("null"), /none has been written/);
  assert.throws(() => sceneModule.readScene("{"), /no JSON/);
  assert.throws(() => sceneModule.readScene(broken((s) => (s.format = "axode scene 9"))), /"axode scene 9"/);
  assert.throws(() => sceneModule.readScene(broken((s) => s.q.pop())), /q has 5 numbers, nq is 6/);
  assert.throws(() => sceneModule.readScene(broken((s) => (s.shapes[0].body = 70))), /body 70/);
  assert.throws(() => sceneModule.readScene(broken((s) => (s.bodies[2].predecessor = 3))), /predecessor of body 2/);
  assert.throws(() => sceneModule.readScene(broken((s) => s.motion.twists.pop())), /120 samples of twists and 121 of t/);
});

test("no name lies on another, and the first stay where they are", () => {
  const height = 16;
  let seed = 1;
  const random = () => (seed = (16807 * seed) % 2147483647) / 2147483647;
  const places = Array.from({ length: 200 }, () => ({ x: 400 * random(), y: 300 * random(), width: 20 + 80 * random() }));
  places.push({ x: 0, y: 0, width: 0 }); // behind the camera
  const rows = labels.rowsOf(places, height);
  assert.equal(rows[0], 0);
  assert.equal(rows[200], 0);
  assert.ok(rows.includes(null) && rows.filter((row) => row === 0).length > 20);
  const shown = places.map((place, k) => ({ ...place, y: place.y + rows[k] * height })).filter(({ width }, k) => rows[k] !== null && width > 0);
  shown.forEach((a, i) => shown.slice(0, i).forEach((b) => {
    assert.ok(Math.abs(a.y - b.y) >= 0.99 * height || a.x >= b.x + b.width || b.x >= a.x + a.width, `${JSON.stringify(a)} on ${JSON.stringify(b)}`);
  }));
  assert.deepEqual(labels.rowsOf(Array(3).fill({ x: 5, y: 7, width: 30 }), height), [0, 1, 2]);
  assert.deepEqual(labels.rowsOf([{ x: 5, y: 7, width: 30 }, { x: 9, y: 20, width: 30 }, { x: 5, y: 7, width: 30 }], height), [0, null, 1]);
  assert.deepEqual(labels.rowsOf([{ x: 0, y: 0, width: 30 }, { x: 30, y: 0, width: 30 }], height), [0, 0]);
});

/** Scales of frames that take `time(scale)` milliseconds, from the first after a rest. */
function scalesOf(drawn, count, time) {
  return Array.from({ length: count }, () => {
    drawn.took(time(drawn.scale));
    return drawn.scale;
  });
}

test("what moves is drawn at a lower resolution where frames take too long for it, and sharply at rest", () => {
  const drawn = new resolution.Resolution();
  assert.ok(scalesOf(drawn, 100, () => 27).every((scale) => scale === 1), "frames are quick enough");
  let frame = 0;
  assert.ok(scalesOf(drawn, 100, () => (++frame % 3 === 0 ? 500 : 16)).every((scale) => scale === 1), "some are late");

  const filled = scalesOf(drawn, 100, (scale) => 10 + 60 * scale ** 2);
  assert.deepEqual([...new Set(filled)], [1, 0.75, 0.5], "down, step by step");
  assert.equal(filled.indexOf(0.5), 9, "soon");
  assert.equal(drawn.rest(), true);
  assert.equal(drawn.scale, 1);
  assert.equal(drawn.rest(), false);

  const halfway = scalesOf(drawn, 100, (scale) => 5 + 30 * scale ** 2);
  assert.deepEqual([...new Set(halfway)], [1, 0.75], "no further than frames need");
  drawn.rest();

  const inVain = scalesOf(drawn, 100, () => 60);
  assert.equal(inVain.indexOf(0.5), 9);
  assert.ok(inVain.slice(14).every((scale) => scale === 1), "full again where pixels are not what takes time");
  drawn.rest();
  assert.ok(scalesOf(drawn, 100, () => 60).every((scale) => scale === 1), "and not tried again");
  drawn.rest();
  assert.equal(scalesOf(drawn, 100, (scale) => 20 + 80 * scale ** 2).at(-1), 0.5, "unless frames take longer than then");
});

test("the resolution does not flicker, whatever frames take", () => {
  const next = random(23);
  for (let k = 0; k < 50; ++k) {
    const drawn = new resolution.Resolution();
    const scales = scalesOf(drawn, 400, () => 28 + 20 * next());
    const changes = scales.filter((scale, i) => i > 0 && scale !== scales[i - 1]).length;
    assert.ok(changes <= 3, `${changes} changes`);
  }
});

/** Entries of a pose that are all 0 if and only if it turns nothing. */
const turned = (D) => [D[0][1], D[0][2], D[1][2], D[0][0] - 1, D[1][1] - 1, D[2][2] - 1];

/**
 * What each kind of loop joint leaves of the pose D of its second
 * end in its first one: numbers that are 0 where it is closed.
 */
const FORBIDDEN = {
  fixed: (D) => [...D.slice(0, 3).flat()].map((x, k) => x - [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0][k]),
  revolute: (D) => [D[0][3], D[1][3], D[2][3], D[0][2], D[1][2], D[2][2] - 1],
  prismatic: (D) => [D[0][3], D[1][3], ...turned(D)],
  helical: (D, { pitch }) => [D[0][3], D[1][3], D[0][2], D[1][2], D[2][2] - 1, Math.sin((D[2][3] / pitch - Math.atan2(D[1][0], D[0][0])) / 2)],
  cylindrical: (D) => [D[0][3], D[1][3], D[0][2], D[1][2], D[2][2] - 1],
  spherical: (D) => [D[0][3], D[1][3], D[2][3]],
  planar: (D) => [D[2][3], D[0][2], D[1][2], D[2][2] - 1],
  translational: (D) => turned(D),
  universal: (D, { size }) => [D[0][3], D[1][3], D[2][3], D[2][2] - size],
  rod: (D, { size }) => [Math.hypot(D[0][3], D[1][3], D[2][3]) - size],
  rolling: (D, { size, wheel }) => [D[2][3] - size * (wheel ? Math.sqrt(1 - D[2][2] ** 2) : 1)],
};

/**
 * A body that a loop joint holds beside its own joint, which is free, and what each of its coordinates does.
 */
function heldBody(kind, next) {
  const builder = new SceneBuilder(kind);
  const body = builder.body("body", 0, "free", frameAt([0.1, 0.2, 0.3], [1, 2, 3]), { A: frameAt([0.3, -0.2, 0.1], [0, 1, 1]) });
  const sizes = { universal: 0.2, rod: 0.4, rolling: 0.15 };
  const pose = () => poseOf(exp([next(), next(), next(), next(), next(), next()]));
  const [a, b] = [pose(), pose()];
  builder.scene.loops.push({ name: "loop", kind, ends: [{ body: 0, pose: a }, { body, pose: b }], pitch: kind === "helical" ? 0.05 : 0, size: sizes[kind] ?? 0, wheel: next() > 0 });
  const D = (q) => times(inverse(matrixOf(a)), times(poses(builder.scene, q)[1], matrixOf(b)));
  return { scene: builder.scene, D };
}

for (const kind of Object.keys(FORBIDDEN)) {
  test(`a ${kind} loop joint is closed from nearby`, () => {
    const next = random(41);
    let closed = 0;
    for (let k = 0; k < 20; ++k) {
      const { scene, D } = heldBody(kind, next);
      const loops = new closure.Closure(scene);
      // A place where the ends are near each other, apart from what closes it.
      const { kind: _, ends: [{ pose: a }, { pose: b }], size } = scene.loops[0];
      const near_it = times(matrixOf(a), exp([0.1 * next(), 0.1 * next(), 0.1 * next(), 0.05 * next(), 0.05 * next(), kind === "rolling" ? size : 0.05]));
      const along = kind === "rod" ? exp([0, 0, 0, size, 0, 0]) : kind === "universal" ? exp([Math.PI / 2, 0, 0, 0, 0, 0]) : kind === "rolling" && scene.loops[0].wheel ? exp([Math.PI / 2, 0, 0, 0, 0, 0]) : exp([0, 0, 0, 0, 0, 0]);
      const { joint, S_prev, S_self } = scene.bodies[1];
      const J = poseOf(times(inverse(matrixOf(S_prev)), times(times(near_it, along), times(inverse(matrixOf(b)), matrixOf(S_self)))));
      const q = [...J.slice(3), ...J.slice(0, 3)];
      assert.equal(q.length, joint.nq);
      const found = loops.close(q, Array(6).fill(false));
      if (!found) continue;
      ++closed;
      FORBIDDEN[kind](D(found), scene.loops[0]).forEach((x) => assert.ok(Math.abs(x) < 1e-10, `${kind}: ${x}`));
      assert.ok(loops.gap(found) < 1e-11);
    }
    assert.ok(closed >= 18, `${closed} of 20 closed`);
  });
}

test("a crank goes round with its loop closed, and a rocker stops where the loop ends its way", () => {
  const scene = fourBar();
  const loops = new closure.Closure(scene);
  let q = scene.q;
  for (let k = 0; k < 24; ++k) {
    const from = q[0];
    const { q: to, part } = loops.lead(q, 1, (s) => [from + (s * Math.PI) / 6], Math.PI / 6, []);
    assert.equal(part, 1);
    near([to[0]], [from + Math.PI / 6]);
    assert.ok(loops.gap(to) < 1e-11);
    q = to;
  }
  near([Math.sin(q[2] - scene.q[2])], [0], 1e-8, "after two turns all is where it was");
  const from = q[2];
  const { q: to, part } = loops.lead(q, 3, (s) => [from + 3 * s], 3, []);
  assert.ok(part > 0 && part < 1 && loops.gap(to) < 1e-11);
  // The rocker ends where crank and coupler are in one line:
  // their lengths add up to the distance from its pin.
  const reach = Math.hypot(0.8 + 0.6 * Math.cos(to[2]), 0.6 * Math.sin(to[2]));
  assert.ok(Math.min(Math.abs(reach - 1.0), Math.abs(reach - 0.4)) < 1e-4, `${reach}`);
});

test("a joint moves on in long steps after short ones, and does not go on for ever in short ones", () => {
  const scene = fourBar();
  const loops = new closure.Closure(scene);
  const close = loops.close.bind(loops);
  let [calls, last] = [0, scene.q[0]];
  const turned = (isRefused) => {
    [calls, last] = [0, scene.q[0]];
    loops.close = (q, held) => {
      ++calls;
      if (isRefused(q)) return null;
      last = q[0];
      return close(q, held);
    };
    return loops.lead(scene.q, 1, (s) => [scene.q[0] + 3 * s], 3, []).part;
  };
  assert.equal(turned(() => calls <= 10), 1);
  assert.ok(calls < 100, `${calls} steps`);
  assert.ok(turned((q) => Math.abs(q[0] - last) > 1e-4) < 1);
  assert.ok(calls <= 400, `${calls} steps`);
});

test("drives and chosen joints stay while another one moves, if the loops allow it; couplings hold", () => {
  const builder = new SceneBuilder("two cranks");
  const joints = [0, 1, 2].map((k) => builder.body(`c${k}`, 0, "revolute", frameAt([k, 0, 0])));
  builder.scene.couplings = [{ name: "sum", terms: [[0, 1], [1, 2], [2, 1]], offset: 0 }];
  const loops = new closure.Closure(builder.scene);
  const { q } = loops.lead([0, 0, 0], joints[0], (s) => [0.3 * s], 0.3, [joints[1]]);
  near(q, [0.3, 0, -0.3]);
  const next = loops.lead(q, joints[2], (s) => [-0.3 + 0.5 * s], 0.5, [joints[0], joints[1]]);
  near([next.q[0] + 2 * next.q[1] + next.q[2], next.q[2], next.part], [0, 0.2, 1]);
});

test("ticks are not rounded", () => {
  const step = (from, by, n) => Array.from({ length: n }, (_, k) => from + k * by);
  assert.deepEqual(step(-0.5, 0.25, 5).map((x) => ticks.tickText(x, 0.25)), ["−0.50", "−0.25", "0", "0.25", "0.50"]);
  assert.deepEqual(step(-5, 2.5, 3).map((x) => ticks.tickText(x, 2.5)), ["−5.0", "−2.5", "0"]);
  for (const by of [1, 2, 2.5, 5, 0.1, 0.2, 0.25, 0.5, 0.025, 1e-3, 2.5e-4, 2.5e-9, 2e7, 2.5e8]) {
    for (const x of step(-3 * by, by, 8)) {
      const read = Number(ticks.tickText(x, by).replace("−", "-"));
      assert.ok(Math.abs(read - x) <= 1e-9 * by, `${x} by ${by} reads ${read}`);
    }
  }
});

test("arrows of wrenches stand at their joints, with the moment about them and to the scale of the legend", () => {
  const scene = movedArm;
  const state = new stateModule.State(scene);
  const stage = { unit: 0.1, radius: 1 };
  const layers = vectors.vectorLayers({ scene, state, stage, history: new history.History(scene), meshes: [] });
  const layer = layers.find(({ id }) => id === "wrenches");
  state.select(4);
  state.setTime(scene.motion.t[30]);
  layer.update();
  const C = poses(scene, scene.motion.q[30])[4];
  const joint = apply(C, scene.bodies[4].S_self.slice(0, 3));
  const W = scene.motion.wrenches[30][3];
  const moment = W.slice(0, 3).map((m, k) => m - cross(joint, W.slice(3))[k]);
  layer.root.children.forEach((arrows, k) => {
    const [shafts, heads] = arrows.children;
    assert.equal(shafts.count, 1);
    const [from, tip] = [shafts, heads].map((mesh) => {
      const matrix = new Matrix4();
      mesh.getMatrixAt(0, matrix);
      return new Vector3().setFromMatrixPosition(matrix).toArray();
    });
    near(from, joint, 1e-6);
    const scale = layer.scales().find(({ heads: n }) => n === 2 - k);
    near(tip.map((x, c) => (x - from[c]) * scale.each), k === 0 ? moment : W.slice(3), 1e-5);
  });
});
