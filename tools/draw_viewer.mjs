/**
 * Draws the pictures of docs/ that show the viewer, in a headless Chromium: docs/viewer.png, docs/bricard.png, which moves,
 * and one picture of each mechanism that comes with axode in docs/gallery. The commands below the pictures in docs/gallery.md
 * make the motions. After `make build`: node tools/draw_viewer.mjs [NAME ...]
 */
import { execFileSync } from "node:child_process";
import { cpSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { indexedPng } from "./indexed_png.mjs";

const source = fileURLToPath(new URL("..", import.meta.url));
const build = join(source, "build/release");
const { chromium } = createRequire(join(build, "viewer/package.json"))("playwright-core");

/**
 * A picture: what is shown of a motion: layers, the chosen body, the time, and what the page has besides the view. `orbit`
 * turns and lifts the camera, in rad, and zooms. A picture with `frames` moves through the times from 0 to `until`. A picture
 * that is not in the gallery has `commands` of its own.
 */
const SMALL = { width: 460, height: 320 };
const TRACED = ["traces"];
const PICTURES = {
  viewer: {
    commands: `echo '{"q": {"A1": -0.6, "A2": 0.4, "A4": -1.3, "A6": 0.8}}' > state.json
echo '{"q": {"A1": 1.2, "A2": 1.3, "A4": -0.9, "A6": 1.2}}' |
  axode simulate arm7.toml --state state.json --target - --pd 300,60 --until 1.5 --samples 150 --output run.csv
axode view arm7.toml --motion run.csv`,
    layers: ["screw-axis", "fixed-axode", "moving-axode"], body: "link 4", time: 0.3, orbit: [0, 0.1, 1.15], show: "page",
    width: 1000, height: 700, file: "docs/viewer.png",
  },
  bricard: {
    layers: ["fixed-axode", "moving-axode", "screw-axis"], body: "rod 3", frames: 52, until: 4.15, orbit: [0, 0, 1.2], show: "plots",
    width: 920, height: 400, file: "docs/bricard.png",
  },
  andrews: { layers: TRACED, time: 0.012, ...SMALL },
  arm7: { time: 0.7, ...SMALL },
  cart: { time: 2, orbit: [0.3, 0.1, 1.2], ...SMALL },
  delta: { time: 0.6, orbit: [0, 0, 0.95], ...SMALL },
  double_pendulum: { layers: TRACED, time: 0.9, ...SMALL },
  excavator: { time: 1.6, ...SMALL },
  five_bar_arm: { layers: TRACED, time: 0.2, ...SMALL },
  four_bar: { layers: TRACED, time: 0.1, ...SMALL },
  gough: { time: 0.6, ...SMALL },
  governor: { time: 0.35, orbit: [-0.6, -0.1, 1.1], ...SMALL },
  humanoid: { time: 0.3, ...SMALL },
  leg: { time: 0.3, ...SMALL },
  machine: { time: 0.4, ...SMALL },
  n_four_bar: { layers: TRACED, time: 0.5, ...SMALL },
  quadruped: { time: 0.2, ...SMALL },
  radial_drill: { time: 1.2, orbit: [0.15, -0.1, 1.15], ...SMALL },
  slider_crank: { time: 0.3, ...SMALL },
};

/** The commands below each picture of the gallery, by the name of the picture. */
const page = readFileSync(join(source, "docs/gallery.md"), "utf8");
const blocks = page.matchAll(/^!\[[^\]]*\]\((?:gallery\/)?(\w+)\.png\)$(?:(?!^!\[)[^])*?^```\n([^]*?)^```$/gm);
const COMMANDS = Object.fromEntries([...blocks].map(([, name, commands]) => [name, commands.trim()]));

const folder = mkdtempSync(join(tmpdir(), "axode-"));
cpSync(join(source, "examples/robots"), folder, { recursive: true });

/** Runs the commands of a picture, the last of which writes its page. */
function pageOf(name, commands = COMMANDS[name]) {
  if (!commands) throw new Error(`docs/gallery.md has no commands below the picture "${name}"`);
  const script = `${commands} --output page.html`;
  execFileSync("sh", ["-ec", script], { cwd: folder, env: { ...process.env, PATH: `${build}:${process.env.PATH}` } });
  return join(folder, "page.html");
}

/**
 * Shows the plots of q and of the energy, and leaves of the page
 * the view, or the view with plots beside it. Runs in the page.
 */
function arrange(show) {
  for (const button of document.querySelectorAll(".choices button")) {
    const wanted = ["q", "energy"].includes(button.textContent);
    if (wanted !== (button.getAttribute("aria-pressed") === "true")) button.click();
  }
  const hide = (selector) => document.querySelectorAll(selector).forEach((element) => (element.style.display = "none"));
  if (show === "page") return;
  hide("header, #panel, .views, #player, .choices, #note, #legend");
  const main = document.querySelector("main");
  [main.style.flex, main.style.height] = ["none", "100vh"];
  main.style.grid = show === "plots" ? '"view time" minmax(0, 1fr) / minmax(0, 1fr) 340px' : '"view" minmax(0, 1fr) / minmax(0, 1fr)';
  const time = document.querySelector("#time");
  if (show !== "plots") time.style.display = "none";
  time.style.borderTop = "0";
  const drawings = document.querySelector(".drawings");
  if (drawings) [drawings.style.maxHeight, drawings.style.paddingTop] = ["none", "8px"];
}

/** Hides that the page is drawn in software, where the viewer would leave out what costs time. Runs before the page. */
function drawAll() {
  const extension = WebGL2RenderingContext.prototype.getExtension;
  WebGL2RenderingContext.prototype.getExtension = function (name) {
    return name === "WEBGL_debug_renderer_info" ? null : extension.call(this, name);
  };
}

/** The pixels of a PNG. Runs in the page. */
async function pixelsOf(png) {
  const bytes = Uint8Array.from(atob(png), (c) => c.charCodeAt(0));
  const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
  const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
  context.drawImage(bitmap, 0, 0);
  const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
  let text = "";
  for (let k = 0; k < data.length; k += 32768) text += String.fromCharCode(...data.subarray(k, k + 32768));
  return btoa(text);
}

const wanted = process.argv.slice(2);
const unknown = wanted.find((name) => !(name in PICTURES));
if (unknown) throw new Error(`There is no picture "${unknown}"; there are ${Object.keys(PICTURES).join(", ")}.`);
mkdirSync(join(source, "docs/gallery"), { recursive: true });
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});
for (const [name, picture] of Object.entries(PICTURES)) {
  if (wanted.length > 0 && !wanted.includes(name)) continue;
  const { width, height, layers = [], body, time, frames = 1, until = 0, orbit = [0, 0, 1] } = picture;
  const tab = await browser.newPage({ viewport: { width, height } });
  tab.setDefaultTimeout(120_000);
  await tab.addInitScript(drawAll);
  await tab.goto(`file://${pageOf(name, picture.commands)}`);
  await tab.waitForSelector("#canvas[data-ready]");
  await tab.evaluate(arrange, picture.show ?? "view");
  await tab.waitForTimeout(300);
  await tab.evaluate(([on, chosen, [around, above, zoom]]) => {
    for (const layer of on) window.axode.setLayer(layer, true);
    if (chosen) window.axode.select(chosen);
    document.querySelector("#fit").click();
    window.axode.orbit(around, above, zoom);
  }, [layers, body, orbit]);
  const shots = [];
  for (let k = 0; k < frames; ++k) {
    const t = frames > 1 ? (until * k) / frames : time;
    if (t !== undefined) await tab.evaluate((at) => window.axode.setTime(at), t);
    await tab.waitForTimeout(frames > 1 ? 250 : 900);
    const png = (await tab.screenshot()).toString("base64");
    shots.push(Buffer.from(await tab.evaluate(pixelsOf, png), "base64"));
  }
  const bytes = indexedPng(shots, width, height, Math.round((1000 * until) / frames));
  const file = picture.file ?? `docs/gallery/${name}.png`;
  writeFileSync(join(source, file), bytes);
  console.log(`${file}: ${(bytes.length / 1024).toFixed(0)} KiB`);
  await tab.close();
}
await browser.close();
rmSync(folder, { recursive: true });
