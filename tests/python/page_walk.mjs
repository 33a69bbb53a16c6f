/**
 * Opens pages in a real browser and moves every slider on them: node page_walk.mjs
 * NODE_MODULES CHROMIUM. A line in is an address; a line out has, as JSON, the largest gap of
 * the loops while sliders moved, the notes that the page wrote, how many positions were
 * reached, how many pixels of the picture differ from its corners, and what the console said.
 */
import { createRequire } from "node:module";
import { createInterface } from "node:readline";

const [modules, executablePath] = process.argv.slice(2);
const { chromium } = createRequire(`${modules}/`)("playwright-core");
const browser = await chromium.launch({
  executablePath,
  headless: true,
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});

/** Puts each slider at places all over its range, as a hand would, and collects what the page makes of it. */
async function moveSliders() {
  const note = document.querySelector("#note");
  const loops = JSON.parse(document.querySelector("#scene").textContent).loops.length > 0;
  const result = { gap: window.axode.gap(), notes: [], asked: 0, reached: 0 };
  for (const slider of document.querySelectorAll("#joints input[type=range]:not(:disabled)")) {
    const [low, high] = [Number(slider.min), Number(slider.max)];
    for (const part of loops ? [0.3, 0.9, 0.5] : [0.9]) {
      const value = low + part * (high - low);
      slider.value = String(value);
      slider.dispatchEvent(new Event("input", { bubbles: true }));
      if (loops) {
        await new Promise(requestAnimationFrame); // then the note is written
        await new Promise((done) => setTimeout(done, 0));
      }
      result.gap = Math.max(result.gap, window.axode.gap());
      ++result.asked;
      if (/cannot reach/.test(note.textContent)) result.notes.push(note.textContent);
      else ++result.reached;
    }
    document.querySelector("#joints button").click();
  }
  return result;
}

/** How many pixels of the view are unlike those of its upper corners. */
async function drawnPixels() {
  const bitmap = await createImageBitmap(await window.axode.png());
  const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
  context.drawImage(bitmap, 0, 0);
  const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
  let count = 0;
  for (let k = 0; k < data.length; k += 4) {
    if ([0, 1, 2].some((c) => Math.abs(data[k + c] - data[c]) > 40)) ++count;
  }
  return count;
}

const page = await browser.newPage({ viewport: { width: 480, height: 240 } });
page.setDefaultTimeout(120000);
let said;
page.on("console", (message) => ["error", "warning"].includes(message.type()) && said.push(message.text()));
page.on("pageerror", (error) => said.push(String(error)));
for await (const line of createInterface({ input: process.stdin })) {
  said = [];
  await page.goto(line);
  await page.waitForSelector("#canvas[data-ready]");
  const pixels = await page.evaluate(drawnPixels);
  const moved = await page.evaluate(moveSliders);
  console.log(JSON.stringify({ ...moved, pixels, said }));
}
await browser.close();
