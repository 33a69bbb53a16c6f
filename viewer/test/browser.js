import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

const PAGE = fileURLToPath(new URL("../dist/page.html", import.meta.url));
const EMPTY = '<script id="scene" type="application/json">null</script>';

export const executable = process.env.CHROMIUM ?? "/usr/bin/chromium";
export const isInstalled = existsSync(executable);

/** The page with a scene in it, as axode writes it: nothing in a name can end the element. */
export function pageOf(scene) {
  const page = readFileSync(PAGE, "utf8");
  const parts = page.split(EMPTY);
  if (parts.length !== 2) throw new Error(`the page has ${parts.length - 1} places for a scene`);
  const escaped = JSON.stringify(scene).replace(/[<>&\u2028\u2029]/g, (c) => `\\u${c.charCodeAt(0).toString(16).padStart(4, "0")}`);
  return parts.join(EMPTY.replace("null", () => escaped));
}

/** A browser of its own with a folder of its own; close() removes both. */
export async function openBrowser() {
  const folder = mkdtempSync(join(tmpdir(), "axode-viewer-"));
  const context = await chromium.launchPersistentContext(join(folder, "profile"), {
    executablePath: executable,
    headless: true,
    viewport: { width: 640, height: 420 },
    acceptDownloads: true,
    args: [
      "--no-sandbox", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
      "--disable-extensions", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    ],
  });
  context.setDefaultTimeout(120_000); // a busy machine draws slowly
  let pages = 0;
  return {
    context,
    folder,
    /**
     * Opens a scene from a file. `heard` collects what the
     * console says, and `asked` what was asked of a network.
     */
    async open(scene, options = {}) {
      const file = join(folder, `${++pages}.html`);
      writeFileSync(file, pageOf(scene));
      const page = await context.newPage();
      const heard = [];
      const asked = [];
      page.on("console", (message) => ["error", "warning"].includes(message.type()) && heard.push(message.text()));
      page.on("pageerror", (error) => heard.push(String(error)));
      page.on("request", (request) => !/^(file|data|blob):/.test(request.url()) && asked.push(request.url()));
      if (options.first) await page.addInitScript(options.first);
      if (options.dark) await page.emulateMedia({ colorScheme: "dark" });
      if (options.size) await page.setViewportSize(options.size);
      await page.goto(`file://${file}`);
      if (!options.broken) await page.waitForSelector("#canvas[data-ready]");
      return { page, heard, asked };
    },
    async close() {
      await context.close();
      rmSync(folder, { recursive: true, force: true });
    },
  };
}
