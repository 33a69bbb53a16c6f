/** Laws of what is drawn where, and one look at it. */
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { Matrix4, Vector3 } from "three";
import { createServer } from "vite";
import { executable, isInstalled, openBrowser } from "./browser.js";
import { apply, poses } from "./reference.js";
import { arm, fourBar, frameAt, movingArm, SceneBuilder } from "./scenes.js";

const root = fileURLToPath(new URL("..", import.meta.url));
const source = {};
let server;
before(async () => {
  server = await createServer({ root, configFile: false, logLevel: "error", server: { middlewareMode: true, hmr: false, ws: false, watch: null }, optimizeDeps: { noDiscovery: true } });
  for (const name of ["couplings", "ground", "history", "kinematics", "loops", "palette", "scale", "shapes", "state", "vectors"]) {
    source[name] = await server.ssrLoadModule(`/src/${name}.ts`);
  }
});
after(() => server?.close());

const near = (a, b, tolerance = 1e-9) => assert.ok(Math.abs(a - b) <= tolerance, `${a}, expected ${b}`);
const identity = [0, 0, 0, 0, 0, 0, 1];
const stage = { unit: 0.1, radius: 1, pixel: 0.001 };

function extent(scene) {
  const tree = new source.kinematics.Tree(scene.bodies);
  tree.update(scene.q);
  return source.shapes.reach(scene, tree.poses, []);
}

/** A ball of radius 0.1 on a hinge at the inertial origin; the origin of the body is ten metres away. */
function farOrigin(kind = "revolute") {
  const builder = new SceneBuilder("far origin");
  const body = builder.body("ball", 0, kind, frameAt(kind === "revolute" ? [0, 0, 0] : [7, 7, 7]), { A: frameAt([10, 0, 0]), com: [-10, 0, 0.3] });
  builder.shape(body, "sphere", { radius: 0.1 }, { at: frameAt([-10, 0, 0.3]) });
  return builder;
}

test("the extent of a scene is that of its bodies, wherever their origins and the frames of their sliders are", () => {
  for (const kind of ["revolute", "prismatic", "free"]) {
    const farthest = Math.max(...extent(farOrigin(kind).scene).map((point) => point.length()));
    assert.ok(farthest < 0.6, `${kind}: a point is ${farthest} m away`);
  }
});

test("a plane reaches as far as to the point nearest to the bodies", () => {
  const builder = farOrigin();
  builder.shape(0, "plane", {}, { at: frameAt([0, 50, -2]) });
  const heights = extent(builder.scene).map(({ z }) => z);
  near(Math.min(...heights), -2);
  assert.ok(Math.max(...extent(builder.scene).map(({ y }) => y)) < 1);
});

test("a thread reaches as far as its rod, and a socket as half of a ball", () => {
  const builder = new SceneBuilder("screw");
  const body = builder.body("screw", 0, "helical", frameAt([0, 0, 0]), { pitch: 0.01 });
  builder.shape(body, "thread", { radius: 0.1, length: 1, lead: -0.1 });
  const heights = extent(builder.scene).map(({ z }) => z);
  near(Math.min(...heights), -0.5, 0.03);
  near(Math.max(...heights), 0.5, 0.03);
  near(Math.max(...extent(builder.scene).map(({ x }) => x)), 0.1, 0.01);
  builder.scene.shapes = [];
  builder.shape(body, "socket", { radius: 0.2 });
  const points = extent(builder.scene);
  near(Math.min(...points.map(({ z }) => z)), 0, 1e-6);
  near(Math.max(...points.map(({ z }) => z)), 0.2, 1e-6);
});

test("the ground lies at the lowest point, and at zero where that is nearly the lowest", () => {
  const up = new Vector3(0, 0, 1);
  const heightOf = (...heights) => source.ground.heightOfGround(heights.map((z) => new Vector3(3, 1, z)), up, 1);
  assert.equal(heightOf(0.4, 0.9), 0.4);
  assert.equal(heightOf(-0.7, 0.9), -0.7);
  assert.equal(heightOf(1e-5, 0.9), 0);
  assert.equal(heightOf(), 0);
});

/** The matrices of the things that a layer draws, by the place of their group in it. */
function matricesOf(layer) {
  layer.update();
  return layer.root.children
    .filter((part) => part.items)
    .map((part) =>
      part.items.map((_, k) => {
        const matrix = new Matrix4();
        part.getMatrixAt(k, matrix);
        return matrix;
      }),
    );
}

test("a rod reaches from one end of its loop to the other", () => {
  const scene = fourBar();
  scene.loops = [{ name: "rod", kind: "rod", ends: [{ body: 1, pose: [0, 0.3, 0.1, 0, 0, 0, 1] }, { body: 3, pose: identity }], size: 0.5 }];
  const [layer] = source.loops.loopLayers({ scene, state: new source.state.State(scene), stage });
  const [[rod]] = matricesOf(layer);
  const C = poses(scene, scene.q);
  [[1, [0, 0.3, 0.1]], [3, [0, 0, 0]]].forEach(([body, point], end) => {
    const at = new Vector3(0, 0, end).applyMatrix4(rod).toArray();
    apply(C[body], point).forEach((x, k) => near(at[k], x, 1e-6)); // matrices for the graphics card are of single precision
  });
});

test("bodies move in planes if their hinges are parallel and no slider leads out of the planes", () => {
  const normalOf = (...joints) => {
    const builder = new SceneBuilder("planes");
    joints.forEach(([kind, axis], k) => builder.body(`b${k}`, k, kind, frameAt([0.1 * k, 0, 0], axis)));
    const normal = source.kinematics.planeNormal(builder.scene, poses(builder.scene, builder.scene.q).map((C) => new Matrix4().set(...C.flat())));
    return normal?.toArray().map((x) => Math.abs(Math.round(x)));
  };
  const [x, z] = [[1, 0, 0], [0, 0, 1]];
  assert.deepEqual(normalOf(["revolute", z], ["prismatic", x], ["revolute", z]), [0, 0, 1]);
  assert.equal(normalOf(["revolute", z], ["prismatic", z]), undefined);
  assert.equal(normalOf(["revolute", z], ["revolute", x]), undefined);
  assert.equal(normalOf(["prismatic", x]), undefined);
});

test("nothing is drawn between the ends of a closed loop, and a line between those of an open one", () => {
  for (const closed of [true, false]) {
    const scene = fourBar();
    scene.motion = null;
    if (!closed) scene.q = [0, 0, 0];
    const [layer] = source.loops.loopLayers({ scene, state: new source.state.State(scene), stage });
    const [[gap]] = matricesOf(layer);
    const size = gap.getMaxScaleOnAxis();
    assert.ok(closed ? size === 0 : size > 0.01, `it is ${size} m long`);
  }
});

test("the force of a load stands at its frame, and the longest one has the length that the legend names", () => {
  const scene = fourBar();
  const at = [0.1, 0.2, 0];
  scene.motion.load_frames = [{ name: "tip", body: 2, point: at }];
  const force = (k) => [0, 0, 10 + (k % 2)];
  const C = scene.motion.q.map((q) => poses(scene, q)[2]);
  const places = C.map((C_k) => new Vector3(...apply(C_k, at)));
  scene.motion.loads = places.map((p, k) => [[...p.clone().cross(new Vector3(...force(k))).toArray(), ...force(k)]]);
  const state = new source.state.State(scene);
  const layer = source.vectors.vectorLayers({ scene, state, stage, history: new source.history.History(scene) }).find(({ id }) => id === "loads");
  for (const k of [0, 31]) {
    state.setTime(scene.motion.t[k]);
    layer.update();
    const [, second] = layer.root.children;
    const [shafts, heads] = second.children;
    assert.deepEqual([shafts.count, heads.count], [1, 1]);
    const [shaft, head] = [new Matrix4(), new Matrix4()];
    shafts.getMatrixAt(0, shaft);
    heads.getMatrixAt(0, head);
    const [from, tip] = [shaft, head].map((matrix) => new Vector3().setFromMatrixPosition(matrix));
    near(from.distanceTo(places[k]), 0, 1e-6);
    const [scale] = layer.scales();
    assert.deepEqual([scale.heads, scale.unit], [1, "N"]);
    near(tip.distanceTo(from) * scale.each, force(k)[2], 1e-4);
  }
});

test("forty bodies have forty colours, and their curves as many", () => {
  const bodies = Array.from({ length: 40 }, (_, k) => k + 1);
  for (const colour of [source.palette.colorOfBody, source.palette.strokeOfBody]) {
    assert.equal(new Set(bodies.map(colour)).size, 40);
    bodies.forEach((body) => assert.match(colour(body), /^#[0-9a-f]{6}$/));
  }
});

test("a transient does not make all other arrows short; longer arrows are clipped", () => {
  const { scaleOf, toArrow } = source.scale;
  const steady = Array.from({ length: 100 }, (_, k) => 3 + Math.sin(k));
  const even = scaleOf(steady);
  assert.deepEqual(even, { most: Math.max(...steady), clips: false });
  const jump = scaleOf([900, ...steady]);
  assert.ok(jump.clips && jump.most <= 4 && jump.most > 3.8, JSON.stringify(jump));
  near(toArrow(new Vector3(0, 900, 0), jump, 0.5).length(), 0.5);
  near(toArrow(new Vector3(0, jump.most / 2, 0), jump, 0.5).length(), 0.25);
  // Rounding errors of a mechanism that rests most of the time are not what is usual.
  assert.equal(scaleOf([...Array(99).fill(1e-14), 5]).most, 5);
  assert.deepEqual(scaleOf([0, 0]), { most: 0, clips: false });
});

/** Hinges about y at points of the ground, and couplings between their coordinates. */
function hinges(points, couplings) {
  const builder = new SceneBuilder("hinges");
  points.forEach(([at, axis], k) => builder.body(`w${k}`, 0, "revolute", frameAt(at, axis), { A: frameAt(at) }));
  builder.scene.couplings = couplings.map((terms) => ({ name: "c", terms, offset: 0.3 }));
  return builder.scene;
}
const [y, back] = [[0, 1, 0], [0, -1, 0]];

test("couplings of parallel hinges on one body are wheels, by teeth or by a belt", () => {
  const { gearings, radii, teeth } = source.couplings;
  const points = [[[0, 0, 0], y], [[0.4, 0.2, 0.3], y], [[1, 0, 0], back], [[1, 0, 1], [1, 0, 0]]];
  const turns = (terms) => gearings(hinges(points, [terms])).map((g) => g.turns);
  assert.deepEqual(turns([[0, 2], [1, 1]]), [-2]);
  assert.deepEqual(turns([[0, 2], [2, 1]]), [2]); // about opposite directions
  assert.deepEqual(turns([[0, 2], [3, 1]]), []); // not parallel
  assert.deepEqual(turns([[0, 1], [1, 1], [2, 1]]), []); // a differential
  const touching = radii(-2, 0.6);
  near(touching[0] + touching[1], 0.6);
  near(touching[0], 2 * touching[1]);
  const [a, b] = teeth(touching);
  assert.equal(a, 2 * b);
  const [p, q] = radii(0.5, 0.6);
  near(p / q, 0.5);
  assert.ok(p + q < 0.6);
});

test("teeth of coupled wheels stay in gaps while the wheels turn", () => {
  const scene = hinges([[[0, 0, 0], y], [[0.6, 0, 0], y]], [[[0, 2], [1, 1]]]);
  for (const q of [0, 0.05, 0.4, 2]) {
    scene.q = [q, 0.3 - 2 * q];
    const layer = source.couplings.couplings({ scene, state: new source.state.State(scene), stage });
    const wheels = matricesOf(layer);
    assert.equal(wheels.length, 2);
    const [[first], [second]] = wheels;
    const [n, m] = [24, 12];
    /** The phase of the teeth of a wheel in an inertial direction, in teeth. */
    const phase = (matrix, count, direction) => {
      const inBody = direction.clone().transformDirection(matrix.clone().invert());
      return (Math.atan2(inBody.y, inBody.x) * count) / (2 * Math.PI);
    };
    const sum = phase(first, n, new Vector3(1, 0, 0)) + phase(second, m, new Vector3(-1, 0, 0));
    // On the line of centres a tooth of one wheel meets a gap of the other: m/2 teeth from its first gap at π.
    near(Math.abs(Math.sin(Math.PI * (sum - m / 2))), 0, 1e-6);
  }
});

test("bodies have edges, and arrows that are clipped a legend that says so", { skip: isInstalled ? false : `there is no ${executable}` }, async () => {
  const browser = await openBrowser();
  try {
    const white = arm(1);
    white.scene.shapes.forEach((shape) => (shape.color = [1, 1, 1, 1]));
    const { page, heard } = await browser.open(white.scene);
    const dark = await page.evaluate(async () => {
      const bitmap = await createImageBitmap(await window.axode.png());
      const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
      context.drawImage(bitmap, 0, 0);
      const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
      return data.filter((red, k) => k % 4 === 0 && Math.abs(red - 0x2b) + Math.abs(data[k + 1] - 0x33) + Math.abs(data[k + 2] - 0x3c) < 12).length;
    });
    assert.ok(dark > 300, `${dark} pixels have the colour of edges`);
    const scene = movingArm();
    scene.motion.wrenches[0] = scene.motion.wrenches[0].map((W) => W.map((x) => 1e3 * x + 1e3));
    const moved = await browser.open(scene);
    await moved.page.evaluate(() => (window.axode.setLayer("wrenches", true), window.axode.setTime(1)));
    await moved.page.waitForFunction(() => document.querySelector("#legend").textContent.includes("longer arrows clipped"));
    // A load of 20 N stands at the point of its frame, and the legend has its scale.
    const loaded = movingArm();
    loaded.motion.load_frames = [{ name: "flange", body: loaded.bodies.length - 1, point: [0, 0, 0.3] }];
    loaded.motion.loads = loaded.motion.t.map(() => [[0, 0, 0, 0, 0, -20]]);
    const pulled = await browser.open(loaded);
    assert.equal(await pulled.page.evaluate(() => window.axode.layers().loads), true);
    await pulled.page.waitForFunction(() => document.querySelector("#legend").textContent.match(/\d N$/));
    await pulled.page.click("#tab-layers");
    await pulled.page.waitForFunction(() => document.querySelector("#layers").textContent.includes("at the frame on which it acts"));
    assert.deepEqual([heard, moved.heard, pulled.heard], [[], [], []]);
  } finally {
    await browser.close();
  }
});
