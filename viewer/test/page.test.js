/** The page in a real browser: what a person sees, and what a program around it is told. */
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { executable, isInstalled, openBrowser } from "./browser.js";
import { poses } from "./reference.js";
import { arm, everyKind, fourBar, frameAt, many, movingArm, SceneBuilder, top } from "./scenes.js";

const options = { skip: isInstalled ? false : `there is no ${executable}` };
let browser;
before(async () => {
  if (isInstalled) browser = await openBrowser();
});
after(() => browser?.close());

/** Fails unless the page's poses are those computed apart from it. */
async function standsAt(page, scene, q, tolerance = 1e-9) {
  const shown = await page.evaluate(() => window.axode.poses());
  poses(scene, q).forEach((C, i) => {
    const name = scene.bodies[i].name;
    for (let row = 0; row < 4; ++row) {
      for (let column = 0; column < 4; ++column) {
        const difference = Math.abs(shown[name][4 * column + row] - C[row][column]);
        assert.ok(difference <= tolerance, `${name} at (${row}, ${column}): off by ${difference}`);
      }
    }
  });
}

/** Keeps the canvas as it is drawn now under a name, in the page. */
async function keep(page, name) {
  await page.evaluate(async (key) => {
    const bitmap = await createImageBitmap(await window.axode.png());
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    window.kept = { ...window.kept, [key]: context.getImageData(0, 0, bitmap.width, bitmap.height) };
  }, name);
}

/** How many pixels of two pictures that were kept differ by more than a little. */
async function changed(page, before, after) {
  return page.evaluate(([a, b]) => {
    const [first, second] = [window.kept[a].data, window.kept[b].data];
    let count = first.length === second.length ? 0 : Infinity;
    for (let k = 0; k < first.length; k += 4) {
      if ([0, 1, 2].some((c) => Math.abs(first[k + c] - second[k + c]) > 12)) ++count;
    }
    return count;
  }, [before, after]);
}

/** Waits until nothing more is drawn: the page draws only what changes. */
async function settled(page) {
  await page.waitForFunction(() => {
    const frames = window.axode.frames();
    return new Promise((done) => setTimeout(() => done(window.axode.frames() === frames), 200));
  });
}

const quiet = ({ heard, asked }) => assert.deepEqual({ heard, asked }, { heard: [], asked: [] });

test("a motion is shown, played, scrubbed and drawn, without a word to console or network", options, async () => {
  const scene = movingArm();
  const opened = await browser.open(scene);
  const { page } = opened;
  await standsAt(page, scene, scene.motion.q[0]);

  await page.evaluate((t) => window.axode.setTime(t), scene.motion.t[70]);
  await standsAt(page, scene, scene.motion.q[70]);
  await page.keyboard.press("ArrowRight");
  await standsAt(page, scene, scene.motion.q[71]);

  await page.focus("#canvas");
  await page.keyboard.press("Space");
  assert.equal(await page.textContent("#play"), "Pause");
  await page.waitForFunction((t) => window.axode.time() > t, scene.motion.t[72]);
  await page.keyboard.press("Space");
  assert.equal(await page.textContent("#play"), "Play");
  const stopped = await page.evaluate(() => window.axode.time());
  assert.match(await page.textContent("#spoken-time"), /^Time [\d.]+ seconds$/);
  await page.waitForTimeout(150);
  assert.equal(await page.evaluate(() => window.axode.time()), stopped);

  await page.focus("#scrub");
  await page.keyboard.press("ArrowLeft");
  const behind = await page.evaluate(() => window.axode.time());
  assert.ok(behind < stopped && scene.motion.t.includes(behind));
  await page.focus("#canvas");
  await page.keyboard.press("Home");
  assert.equal(await page.evaluate(() => window.axode.time()), 0);

  // The plots have the time cursor, and move it.
  const over = page.locator(".u-over").first();
  const { width } = await over.boundingBox();
  await over.click({ position: { x: width / 2, y: 20 } });
  const box = await over.boundingBox();
  assert.ok(Math.abs((await page.evaluate(() => window.axode.time())) - 3) < 0.05);
  const cursor = await page.locator(".cursor").first().boundingBox();
  assert.ok(Math.abs(cursor.x - (box.x + box.width / 2)) < 3);

  await settled(page);
  quiet(opened);

  // Every layer changes the picture, and leaves it as it was when switched off again.
  await page.evaluate(() => window.axode.setTime(1.4));
  for (const button of await page.$$(".choices button[aria-pressed=true]")) await button.click();
  await settled(page);
  const ids = Object.keys(await page.evaluate(() => window.axode.layers()));
  assert.deepEqual(ids.sort(), [
    "collision", "com", "ellipsoids", "fixed-axode", "frames", "ground", "joints", "momenta", "moving-axode", "names",
    "screw-axis", "shapes", "traces", "twists", "wrenches",
  ]);
  await keep(page, "plain");
  for (const id of ids) {
    const on = (await page.evaluate(() => window.axode.layers()))[id];
    await page.evaluate(([layer, to]) => window.axode.setLayer(layer, to), [id, !on]);
    await keep(page, "switched");
    const pixels = await changed(page, "plain", "switched");
    assert.ok(pixels > 60, `${id} changes ${pixels} pixels`);
    await page.evaluate(([layer, to]) => window.axode.setLayer(layer, to), [id, on]);
  }
  await keep(page, "again");
  assert.equal(await changed(page, "plain", "again"), 0);
  await page.close();
});

test("sliders put bodies where another computation has them; coupled joints follow", options, async () => {
  const scene = everyKind();
  const opened = await browser.open(scene);
  const { page } = opened;
  const q = scene.q.slice();
  const set = async (label, value) => {
    const box = page.locator(`input[type=number][aria-label="${label}"]`);
    await box.fill(String(value));
    await box.press("Enter");
  };
  await set("column joint, m", 0.3);
  await set("screw joint, rad", -1.7);
  await set("hinge joint, rad", 1.5);
  [q[0], q[1], q[6]] = [0.3, -1.7, 1.5];
  await standsAt(page, scene, q);
  await page.waitForFunction(() => Number(document.querySelector('input[type=number][aria-label="nut joint, m"]').value) === 0.049);
  assert.ok(await page.isDisabled('input[type=range][aria-label="nut joint, m"]'));

  for (const [k, x] of [1.1, -0.4, 0.2].entries()) await set(`ball joint r${"xyz"[k]}, rad`, x);
  const angle = Math.hypot(1.1, -0.4, 0.2);
  const s = Math.sin(angle / 2) / angle;
  q.splice(2, 4, 1.1 * s, -0.4 * s, 0.2 * s, Math.cos(angle / 2));
  for (const [k, label] of ["θ, rad", "x, m", "y, m"].entries()) await set(`table joint ${label}`, 0.2 * (k + 1));
  q.splice(7, 3, 0.2, 0.4, 0.2 * 3);
  for (const [k, axis] of ["x", "y", "z"].entries()) await set(`drone joint ${axis}, m`, 0.1 * k - 0.3);
  q.splice(14, 3, -0.3, -0.2, -0.1);
  await standsAt(page, scene, q, 1e-6);

  // A slider by the keyboard: a hundredth of its range for each key.
  await page.focus('input[type=range][aria-label="hinge joint, rad"]');
  await page.keyboard.press("ArrowRight");
  q[6] += 0.03;
  await standsAt(page, scene, q, 1e-6);

  // States from programs around the page; what is no state is passed over.
  const state = everyKind().q.map((x, k) => ([5, 13].includes(k) ? 1 : k < 2 ? 0.1 : x));
  await page.evaluate((to) => window.postMessage({ axode: { q: to } }), state);
  await page.waitForFunction(() => Math.abs(document.querySelector('input[aria-label="column joint, m"]').value - 0.1) < 1e-9);
  await standsAt(page, scene, state);
  await page.evaluate(() => {
    for (const data of [null, 7, { axode: 1 }, { axode: { q: [1, 2] } }, { axode: { q: Array(17).fill(NaN) } }]) window.postMessage(data);
  });
  await page.waitForTimeout(50);
  await standsAt(page, scene, state);
  await assert.rejects(page.evaluate(() => window.axode.select("nobody")), /no body "nobody"/);
  await assert.rejects(page.evaluate(() => window.axode.setLayer("nothing", true)), /no layer "nothing"/);
  await assert.rejects(page.evaluate(() => window.axode.setState([1])), /q must be 17 finite numbers, got 1/);
  await page.click("text=Reset");
  await standsAt(page, scene, scene.q);
  assert.match(await page.textContent("#layers"), /1 loop stands open/);
  quiet(opened);
  await page.close();
});

test("names are text, whatever is in them", options, async () => {
  const hostile = ["</script><img src=x onerror=\"window.hacked=1\">", "'\"><b>bold</b>", "\u202Eright to left\u202C", "__proto__", "\u2028line", "<!--"];
  const builder = new SceneBuilder(hostile[0]);
  hostile.forEach((name, k) => {
    const body = builder.body(name, k, "revolute", frameAt([0, 0, k]), { joint: `joint of ${name}` });
    builder.shape(body, "sphere", { radius: 0.2 });
    builder.scene.frames.push({ name: `frame of ${name}`, body, pose: [0, 0, 0.5, 0, 0, 0, 1] });
  });
  builder.scene.warnings = hostile.map((name) => `warning of ${name}`);
  const { scene } = builder;
  scene.motion = builder.move((t) => hostile.map((_, k) => t * k), 1, 5).scene.motion;
  scene.motion.series[0].labels = [hostile[0]];
  const opened = await browser.open(scene);
  const { page } = opened;
  for (const id of Object.keys(await page.evaluate(() => window.axode.layers()))) {
    await page.evaluate((layer) => window.axode.setLayer(layer, true), id);
  }
  await page.click("#tab-body");
  await page.click("#tab-warnings");
  await page.waitForTimeout(200);
  assert.equal(await page.textContent("#title"), hostile[0]);
  for (const name of hostile) {
    const found = await page.evaluate((text) => [...document.querySelectorAll(".joint-name b, #warnings li, #body option")].filter((e) => e.textContent.includes(text)).length, name);
    assert.ok(found >= 3, `${name} is shown ${found} times`);
  }
  assert.deepEqual(await page.evaluate(() => [window.hacked, document.querySelectorAll("img, b b, .joint b b").length]), [undefined, 0]);
  assert.ok(await page.evaluate(() => Object.hasOwn(window.axode.poses(), "__proto__")));
  quiet(opened);
  await page.close();
});

const base64 = (text) => Buffer.from(text, "latin1").toString("base64");

/** A tetrahedron of edge 1 in each of the formats. */
function tetrahedra() {
  const v = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
  const f = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
  const facets = f.map((face) => `facet normal 0 0 0\nouter loop\n${face.map((i) => `vertex ${v[i].join(" ")}`).join("\n")}\nendloop\nendfacet`);
  const stl = `solid t\n${facets.join("\n")}\nendsolid t\n`;
  const obj = `${v.map((p) => `v ${p.join(" ")}`).join("\n")}\n${f.map((face) => `f ${face.map((i) => i + 1).join(" ")}`).join("\n")}\n`;
  const dae = `<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="12">${v.flat().join(" ")}</float_array>
<technique_common><accessor source="#a" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>${f.flat().join(" ")}</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>`;
  const bytes = Buffer.concat([Buffer.from(new Float32Array(v.flat()).buffer), Buffer.from(new Uint16Array(f.flat()).buffer)]);
  const gltf = JSON.stringify({
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1, material: 0 }] }],
    materials: [{ pbrMetallicRoughness: { baseColorFactor: [0.8, 0.2, 0.2, 1] } }],
    buffers: [{ byteLength: bytes.length, uri: `data:application/octet-stream;base64,${bytes.toString("base64")}` }],
    bufferViews: [{ buffer: 0, byteOffset: 0, byteLength: 48 }, { buffer: 0, byteOffset: 48, byteLength: 24 }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 4, type: "VEC3", min: [0, 0, 0], max: [1, 1, 1] },
      { bufferView: 1, componentType: 5123, count: 12, type: "SCALAR" },
    ],
  });
  return { stl, obj, dae, gltf };
}

test("meshes of every format are drawn alike; broken ones become warnings", options, async () => {
  const good = tetrahedra();
  const formats = Object.keys(good);
  const side = new SceneBuilder("side by side");
  side.scene.meshes = Object.entries(good).map(([format, text]) => ({ file: `t.${format}`, format, data: base64(text) }));
  formats.forEach((format, k) => {
    const body = side.body(format, 0, "prismatic", frameAt([0, 0, 0]));
    side.shape(body, "mesh", { mesh: k, scale: [0.5, 1, 0.7] }, { color: [0.3, 0.5, 0.8, 1] });
  });
  const opened = await browser.open(side.scene);
  assert.ok(await opened.page.isHidden("#tab-warnings"));
  const blue = {};
  for (const format of formats) {
    await opened.page.evaluate((q) => window.axode.setState(q), formats.map((other) => (other === format ? 0 : 1e4)));
    await keep(opened.page, "mesh");
    blue[format] = await opened.page.evaluate(() => {
      const { data } = window.kept.mesh;
      let [count, shade] = [0, 0];
      for (let k = 0; k < data.length; k += 4) {
        if (data[k + 2] > data[k] + 40) [count, shade] = [count + 1, shade + data[k + 2]];
      }
      return { count, shade };
    });
  }
  assert.ok(blue.stl.count > 1000, `${blue.stl.count} pixels are blue`);
  for (const format of formats) assert.deepEqual(blue[format], blue.stl, format);
  quiet(opened);
  await opened.page.close();

  const builder = new SceneBuilder("broken");
  const body = builder.body("b", 0, "revolute", frameAt([0, 0, 0]));
  const binary = Buffer.alloc(84);
  binary.writeUInt32LE(0xffffffff, 80);
  const broken = {
    "empty.stl": "", "noise.stl": "\x00\x01\x02 not a mesh", "huge.stl": binary.toString("latin1"), "nan.obj": "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "cut.dae": good.dae.slice(0, 300), "cut.gltf": good.gltf.slice(0, 200), "no.glb": "glTF",
    "outside.gltf": good.gltf.replace(/data:application[^"]*/, "http://example.org/a.bin"),
  };
  builder.scene.meshes = Object.entries(broken).map(([file, text]) => ({ file, format: file.split(".")[1], data: base64(text) }));
  builder.scene.meshes.push({ file: "no base64.stl", format: "stl", data: "*" });
  builder.scene.meshes.forEach((_, k) => builder.shape(body, "mesh", { mesh: k }));
  const { page, asked } = await browser.open(builder.scene);
  await page.click("#tab-warnings");
  const lines = await page.$$eval("#warnings li", (items) => items.map((item) => item.textContent));
  for (const { file } of builder.scene.meshes) assert.ok(lines.some((line) => line.includes(`"${file}"`)), `no warning of ${file} in ${lines}`);
  assert.deepEqual(asked, []);
  assert.ok((await page.evaluate(() => Object.keys(window.axode.poses()))).includes("b"));
  await page.close();
});

test("everything is reached by the keyboard, and has a name for those who do not see it", options, async () => {
  const opened = await browser.open(movingArm(), { size: { width: 400, height: 800 } });
  const { page } = opened;
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= 400), "the page is wider than 400 pixels");
  const nameless = await page.$$eval("button, input, select, #canvas", (all) =>
    all.filter((e) => !e.getAttribute("aria-label") && !e.textContent.trim() && !(e.labels && e.labels.length > 0)).map((e) => e.outerHTML));
  assert.deepEqual(nameless, []);
  const unreachable = await page.$$eval("button, input, select, #canvas", (all) =>
    all.filter((e) => e.tabIndex < 0 && e.getAttribute("role") !== "tab").map((e) => e.outerHTML));
  assert.deepEqual(unreachable, []);

  await page.setViewportSize({ width: 900, height: 420 });
  await settled(page);
  await page.focus("#canvas");
  await page.keyboard.press("l");
  assert.ok(await page.isVisible("#layers"));
  await page.keyboard.press("ArrowRight");
  assert.ok(await page.isVisible("#body"));
  await page.keyboard.press("j");
  assert.ok(await page.isVisible("#joints"));
  await page.keyboard.press("?");
  assert.ok(await page.isVisible("#help"));
  assert.match(await page.textContent("#keys"), /play or pause/);
  await page.keyboard.press("Escape");
  assert.ok(await page.isHidden("#help"));

  await page.focus("#canvas");
  await keep(page, "seen");
  await page.keyboard.press("Shift+ArrowLeft");
  await keep(page, "turned");
  assert.ok((await changed(page, "seen", "turned")) > 500, "the view turns");
  await page.keyboard.press("1");
  await page.keyboard.press("d");
  assert.equal(await page.getAttribute("html", "data-theme"), "dark");
  await page.keyboard.press("b");
  await page.keyboard.press("n");
  await page.waitForFunction(() => document.querySelector("#body select").selectedOptions[0].textContent === "ground");
  quiet(opened);

  // A key typed into a number is a number's.
  await page.keyboard.press("j");
  await page.focus('input[type=number][aria-label="A2, rad"]');
  await page.keyboard.press("d");
  assert.equal(await page.getAttribute("html", "data-theme"), "dark");

  // A click chooses a body, and its numbers in four representations are shown.
  await page.click("#tab-body");
  await page.selectOption("#body select", { label: "link 6" });
  const captions = {
    body: "numbers in body axes", spatial: "about the inertial origin", hybrid: "of the body; numbers in inertial axes", mixed: "first three numbers",
  };
  const numbers = new Set();
  for (const [representation, caption] of Object.entries(captions)) {
    await page.selectOption("#body .row:nth-of-type(2) select", representation);
    const twist = page.locator("#body h3:text-is('Twist') + table", { hasText: caption });
    numbers.add(await twist.locator("tbody").textContent());
  }
  assert.equal(numbers.size, 4);

  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#png")]);
  assert.equal(download.suggestedFilename(), "arm.png");
  const stream = await download.createReadStream();
  const bytes = [];
  for await (const chunk of stream) bytes.push(chunk);
  assert.equal(Buffer.concat(bytes).subarray(0, 8).toString("latin1"), "\x89PNG\r\n\x1a\n");
  quiet(opened);
  await page.close();
});

test("a hundred bodies move", options, async () => {
  const scene = many(100);
  const opened = await browser.open(scene);
  const { page } = opened;
  const from = await page.evaluate(() => window.axode.frames());
  await page.click("#play");
  await page.waitForFunction((from) => window.axode.frames() >= from + 3, from);
  await page.click("#play");
  const end = scene.motion.t.length - 1;
  await page.evaluate((t) => window.axode.setTime(t), scene.motion.t[end]);
  await standsAt(page, scene, scene.motion.q[end]);
  quiet(opened);
  await page.close();
});

test("what moves slowly is drawn at a lower resolution, and what rests at the full one", options, async () => {
  // By the clock of this page a frame takes a second for all pixels, and less for fewer.
  const slow = () => {
    const [request, now] = [window.requestAnimationFrame.bind(window), performance.now.bind(performance)];
    let late = 0;
    performance.now = () => now() + late;
    window.widths = [];
    window.requestAnimationFrame = (callback) => request(() => {
      const { width, height, clientWidth, clientHeight } = document.querySelector("#canvas");
      late += (1000 * width * height) / Math.max(1, clientWidth * clientHeight);
      window.widths.push(width / clientWidth);
      callback(performance.now());
    });
  };
  const opened = await browser.open(movingArm(), { first: slow });
  const { page } = opened;
  const width = () => page.$eval("#canvas", (canvas) => canvas.width / canvas.clientWidth);
  await settled(page);
  assert.equal(await width(), 1);
  await keep(page, "before");
  await page.evaluate(() => (window.widths = []));
  await page.click("#play");
  await page.waitForFunction(() => window.widths.at(-1) === 0.5);
  assert.deepEqual(await page.evaluate(() => [...new Set(window.widths)]), [1, 0.75, 0.5]);

  // A picture is sharp while bodies move, and the page at rest.
  const bitmap = await page.evaluate(async () => (await createImageBitmap(await window.axode.png())).width);
  assert.equal(bitmap, await page.$eval("#canvas", (canvas) => canvas.clientWidth));
  await page.waitForFunction(() => window.widths.at(-1) === 0.5);
  await page.click("#play");
  await page.waitForFunction(() => document.querySelector("#canvas").width === document.querySelector("#canvas").clientWidth);
  await page.evaluate(() => window.axode.setTime(0));
  await settled(page);
  assert.equal(await width(), 1);
  await keep(page, "after");
  assert.equal(await changed(page, "before", "after"), 0);
  quiet(opened);
  await page.close();
});

test("points of contact have normals, forces and friction cones, in the colours of their status", options, async () => {
  const scene = movingArm();
  const [open, stick, slide] = [0, 1, 2];
  const point = (x, force, status) => [0, 1, x, 0.2, 0.1, 0, 0, 1, 0, ...force, 0, 0, 0, 0.6, status];
  scene.motion.contact_shapes = ["floor", "foot"];
  scene.motion.contacts = scene.motion.t.map((_, k) => [point(0.4, [3, 0, 9], k < 60 ? stick : slide), point(-0.4, [0, 0, 0], open)]);
  const opened = await browser.open(scene);
  const { page } = opened;
  const ids = ["contacts", "contact-forces", "friction-cones"];
  const layers = await page.evaluate(() => window.axode.layers());
  assert.deepEqual(ids.map((id) => layers[id]), [true, true, false]);
  for (const button of await page.$$(".choices button[aria-pressed=true]")) await button.click();

  // A step of the motion ends at each sample: shortly after sample 59 the point slides.
  const { t } = scene.motion;
  const close = 1e-3 * (t[60] - t[59]);
  for (const [name, time] of [["sticks", t[59]], ["slides", t[59] + close]]) {
    await page.evaluate((at) => window.axode.setTime(at), time);
    await settled(page);
    await keep(page, name);
  }
  assert.ok((await changed(page, "sticks", "slides")) > 30, "the colour shows the status");
  for (const id of ids) {
    await page.evaluate(([layer, to]) => window.axode.setLayer(layer, to), [id, !layers[id]]);
    await keep(page, "switched");
    assert.ok((await changed(page, "slides", "switched")) > 30, `${id} is drawn`);
    await page.evaluate(([layer, to]) => window.axode.setLayer(layer, to), [id, layers[id]]);
  }
  assert.match(await page.textContent("#layers"), /green sticks, orange slides, grey is open/);
  quiet(opened);
  await page.close();
});

test("a page without a scene, or with one it cannot show, says so", options, async () => {
  for (const [scene, text] of [[null, /none has been written into it/], [{ ...arm().scene, format: "axode scene 2" }, /its format is "axode scene 2"/]]) {
    const { page } = await browser.open(scene, { broken: true });
    await page.waitForSelector(".failure");
    assert.match(await page.textContent(".failure"), text);
    await page.close();
  }
  const { page } = await browser.open(arm().scene, { broken: true, first: "HTMLCanvasElement.prototype.getContext = () => null" });
  await page.waitForSelector(".failure");
  assert.match(await page.textContent(".failure"), /no WebGL/);
  await page.close();
});

test("a slider moves a mechanism with its loop closed, and stops where the loop ends its way", options, async () => {
  const opened = await browser.open(fourBar());
  const { page } = opened;
  const set = async (label, value) => {
    const box = page.locator(`input[type=number][aria-label="${label}"]`);
    await box.fill(String(value));
    await box.press("Enter");
    await settled(page);
    return { shown: Number(await box.inputValue()), gap: await page.evaluate(() => window.axode.gap()), note: await page.textContent("#note") };
  };
  for (const angle of [1.4, 2.5, -1]) {
    const { shown, gap, note } = await set("crank, rad", angle);
    assert.equal(shown, angle);
    assert.ok(gap < 1e-9);
    assert.doesNotMatch(note, /cannot reach/);
  }
  const { shown, gap, note } = await set("rocker, rad", 3);
  assert.ok(gap < 1e-9 && shown < 3, `${shown}`);
  assert.match(note, /^rocker cannot reach 3 rad: the loops end its way at [\d.−]+ rad\./);
  assert.equal((await set("crank, rad", 0.5)).note.includes("cannot"), false);
  quiet(opened);
  await page.close();
});

test("the camera follows the chosen body while it moves", options, async () => {
  const opened = await browser.open(top());
  const { page } = opened;
  await page.evaluate(() => window.axode.select("top"));
  await page.click("#follow");
  assert.equal(await page.getAttribute("#follow", "aria-pressed"), "true");
  await settled(page);
  await keep(page, "at once");
  await page.evaluate(() => window.axode.setTime(1.1));
  await page.evaluate(() => window.axode.setTime(0));
  await settled(page);
  await keep(page, "and back");
  assert.equal(await changed(page, "at once", "and back"), 0);
  await page.click("#fit");
  assert.equal(await page.getAttribute("#follow", "aria-pressed"), "false");
  quiet(opened);
  await page.close();
});

test("springs, their forces and the wrenches of loops are drawn, with a legend of their scale", options, async () => {
  const scene = fourBar();
  const samples = scene.motion.t.length;
  scene.lines = [{ ends: [{ body: 0, point: [0, 0.4, 0.9] }, { body: 2, point: [0, 0.35, 0] }], stiffness: 100, rest: 0.4, damping: 5, driven: false }];
  scene.motion.tensions = Array(samples).fill([12]);
  scene.motion.loop_wrenches = Array(samples).fill([[0.5, 0, 0, 0, 3, 4]]);
  const opened = await browser.open(scene);
  const { page } = opened;
  assert.ok(await page.isHidden("#legend"));
  for (const [id, text] of [["springs", null], ["spring-forces", "N"], ["loop-wrenches", "N m"], ["traces", null]]) {
    const on = (await page.evaluate(() => window.axode.layers()))[id];
    await keep(page, "before");
    await page.evaluate(([layer, to]) => window.axode.setLayer(layer, to), [id, !on]);
    await settled(page);
    await keep(page, "after");
    const pixels = await changed(page, "before", "after");
    assert.ok(pixels > 30, `${id} changes ${pixels} pixels`);
    if (text) assert.ok((await page.textContent("#legend")).includes(text), `${id}: ${await page.textContent("#legend")}`);
    await page.evaluate(([layer, to]) => window.axode.setLayer(layer, to), [id, on]);
  }
  quiet(opened);
  await page.close();
});

test("plots have a panel for each unit, names of joints, and the curves of the chosen body", options, async () => {
  const scene = everyKind();
  const q = scene.q.slice();
  scene.motion = { t: [0, 1], q: [q, q], v: [0, 1].map((s) => scene.velocity_names.map(() => s)), tau: null, series: [], twists: null, wrenches: null, momenta: null };
  const opened = await browser.open(scene, { size: { width: 1280, height: 900 } });
  const { page } = opened;
  const buttons = await page.$$eval(".choices button", (all) => all.map((button) => button.textContent));
  assert.deepEqual(buttons, ["q, rad", "q, quaternion", "q, m", "v, rad/s", "v, m/s"]);
  const labels = () => page.$$eval(".u-legend .u-label", (all) => all.map((label) => label.textContent));
  const shown = await labels();
  for (const name of ["screw joint", "ball joint qw", "drone joint z", "table joint angle"]) assert.ok(shown.includes(name), `${name} in ${shown}`);
  await page.evaluate(() => window.axode.select("drone"));
  await page.selectOption("select[aria-label='Curves of']", "chosen");
  const chosen = await labels();
  assert.ok(chosen.includes("drone joint x") && !chosen.includes("screw joint"), `${chosen}`);
  quiet(opened);
  await page.close();
});
