import { createHash } from "node:crypto";
import { defineConfig } from "vite";

const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;

/**
 * Puts script and style into the page, and a policy by
 * which it runs nothing else and reaches no other machine.
 */
const onePage = {
  name: "one-page",
  enforce: "post",
  generateBundle(_, bundle) {
    const parts = Object.values(bundle);
    const page = parts.find((part) => part.fileName === "page.html");
    const script = parts.find((part) => part.type === "chunk").code.replaceAll("</script", "<\\/script");
    const style = parts.find((part) => part.fileName.endsWith(".css")).source;
    const policy = [
      "default-src 'none'",
      `script-src ${hash(script)}`,
      `style-src ${hash(style)}`,
      "img-src data: blob:",
      "connect-src data: blob: http://127.0.0.1:*", // a program on the same machine may send states
      "base-uri 'none'",
      "form-action 'none'",
    ].join("; ");
    const body = page.source.toString().replace(/\s*<(script type="module"|link rel="(stylesheet|modulepreload)")[^>]*>(<\/script>)?/g, "");
    page.source = body
      .replace("<head>", () => `<head>\n<meta http-equiv="Content-Security-Policy" content="${policy}">`)
      .replace("</head>", () => `<style>${style}</style>\n</head>`)
      .replace("</body>", () => `<script type="module">${script}</script>\n</body>`);
    for (const part of parts) if (part !== page) delete bundle[part.fileName];
  },
};

export default defineConfig({
  plugins: [onePage],
  build: {
    target: "es2022",
    modulePreload: false,
    assetsInlineLimit: Number.MAX_SAFE_INTEGER,
    cssCodeSplit: false,
    chunkSizeWarningLimit: 4000,
    rollupOptions: { input: "page.html", output: { inlineDynamicImports: true } },
  },
});
