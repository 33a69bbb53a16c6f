/** Draws docs/viewer.png: the page of an arm that is led to a target, in a headless Chromium. After `make build`: node tools/draw_viewer.mjs */
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

const source = fileURLToPath(new URL("..", import.meta.url));
const build = join(source, "build/release");
const { chromium } = createRequire(join(build, "viewer/package.json"))("playwright-core");

const folder = mkdtempSync(join(tmpdir(), "axode-"));
const run = join(folder, "run.csv");
const target = join(folder, "target.json");
const page = join(folder, "page.html");
const arm = join(source, "examples/robots/arm7.toml");
const axode = (words, input = "") => execFileSync(join(build, "axode"), words, { input });
writeFileSync(target, '{"q": {"A1": 1.2, "A2": 1.3, "A4": -0.9, "A6": 1.2}}');
axode(["simulate", arm, "--state", "-", "--pd", "300,60", "--target", target, "--until", "1.5", "--samples", "150", "--output", run],
  '{"q": {"A1": -0.6, "A2": 0.4, "A4": -1.3, "A6": 0.8}}');
axode(["view", arm, "--motion", run, "--output", page]);

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});
const tab = await browser.newPage({ viewport: { width: 1000, height: 640 } });
await tab.goto(`file://${page}`);
await tab.waitForSelector("#canvas[data-ready]");
await tab.evaluate(() => {
  for (const layer of ["screw-axis", "fixed-axode", "moving-axode"]) window.axode.setLayer(layer, true);
  window.axode.select("link 4");
  window.axode.setTime(0.3);
});
await tab.waitForTimeout(1000);
await tab.screenshot({ path: join(source, "docs/viewer.png") });
await browser.close();
rmSync(folder, { recursive: true });
