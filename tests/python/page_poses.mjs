/**
 * Opens pages in a real browser and tells where the bodies on them stand: node
 * page_poses.mjs NODE_MODULES CHROMIUM. A line in is an address to open, or nothing,
 * to look again; a line out has the poses as JSON. A page may be in a frame.
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
const page = await browser.newPage({ viewport: { width: 400, height: 300 } });
page.setDefaultTimeout(120000);
for await (const line of createInterface({ input: process.stdin })) {
  if (line) await page.goto(line);
  const frame = page.frames().at(-1);
  await frame.waitForSelector("#canvas[data-ready]");
  console.log(JSON.stringify(await frame.evaluate(() => window.axode.poses())));
}
await browser.close();
