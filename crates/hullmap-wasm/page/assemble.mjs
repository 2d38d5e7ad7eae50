// Completes dist/npm and writes dist/hullmap.html. Called by `./build`.

import { copyFileSync, readFileSync, writeFileSync } from "node:fs";

const here = new URL("..", import.meta.url);
const text = (path) => readFileSync(new URL(path, here), "utf8");
const version = /^version = "(.*)"$/m.exec(text("Cargo.toml"))[1];

const licences = ["LICENSE-APACHE", "LICENSE-MIT", "LICENSES-OF-DEPENDENCIES.txt"];
const description = {
  name: "hullmap",
  version,
  description: "Exact convex hulls and certified collision queries on detailed meshes, in WebAssembly",
  license: "MIT OR Apache-2.0",
  type: "module",
  main: "hullmap.js",
  types: "hullmap.d.ts",
  exports: { ".": { types: "./hullmap.d.ts", node: "./node.js", default: "./hullmap.js" }, "./*": "./*" },
  files: ["hullmap.js", "hullmap.d.ts", "hullmap_bg.wasm", "hullmap_bg.wasm.d.ts", "node.js", ...licences],
  sideEffects: false,
  keywords: ["collision", "convex-hull", "gjk", "physics", "wasm"],
};
writeFileSync(new URL("dist/npm/package.json", here), JSON.stringify(description, null, 2) + "\n");
// `Symbol.dispose` is in no library of TypeScript's that is named after a year.
const types = new URL("dist/npm/hullmap.d.ts", here);
writeFileSync(types, `/// <reference lib="esnext.disposable" />\n${readFileSync(types, "utf8")}`);
copyFileSync(new URL("npm/node.js", here), new URL("dist/npm/node.js", here));

// Scripts and style that the page shares with the report of `bake report`.
const shared = (name) => text(`../hullmap-report/src/page/${name}`);
const script = [
  shared("faults.js"),
  shared("arrays.js"),
  shared("gauss.js"),
  shared("webgl.js"),
  ...["samples.js", "view.js", "motion.js", "baker.js", "page.js", "level.js"].map((name) => text(`page/${name}`)),
].join("\n");
const wasm = readFileSync(new URL("dist/page/hullmap_bg.wasm", here)).toString("base64");
const parts = {
  style: shared("style.css") + text("page/style.css"),
  // `</script` would end the element.
  bindings: text("dist/page/hullmap.js").replaceAll("</script", "<\\/script"),
  worker: text("page/worker.js"),
  script,
  wasm,
  version,
  level: text("page/level.html"),
  licences: ["LICENSE-MIT", "dist/npm/LICENSES-OF-DEPENDENCIES.txt"].map(text).join("\n").replaceAll("&", "&amp;").replaceAll("<", "&lt;"),
};
const page = text("page/index.html").replace(/\{\{(\w+)\}\}/g, (_, name) => parts[name]);
writeFileSync(new URL("dist/hullmap.html", here), page);
