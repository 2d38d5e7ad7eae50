// Completes dist/npm and writes dist/hullmap.html. Called by `./build`.

import { readFileSync, writeFileSync } from "node:fs";

const here = new URL("..", import.meta.url);
const text = (path) => readFileSync(new URL(path, here), "utf8");
const version = /^version = "(.*)"$/m.exec(text("Cargo.toml"))[1];

/** The modules of the package: the runtime, and the baker beside it. */
const MODULES = ["hullmap", "bake"];
const entry = (name) => ({ types: `./${name}.d.ts`, node: `./${name}.node.js`, default: `./${name}.js` });
const licences = ["CITATION.cff", "LICENSE-APACHE", "LICENSE-MIT", "LICENSES-OF-DEPENDENCIES.txt", "SECURITY.md"];
const description = {
  name: "hullmap",
  version,
  description: "Exact convex hulls and certified collision queries on detailed meshes, in WebAssembly",
  license: "MIT OR Apache-2.0",
  type: "module",
  main: "hullmap.js",
  types: "hullmap.d.ts",
  exports: { ".": entry("hullmap"), "./bake": entry("bake"), "./*": "./*" },
  files: [...MODULES.flatMap((name) => [".js", ".d.ts", "_bg.wasm", "_bg.wasm.d.ts", ".node.js"].map((end) => name + end)), ...licences],
  sideEffects: false,
  keywords: ["collision", "convex-hull", "gjk", "physics", "wasm"],
};
writeFileSync(new URL("dist/npm/package.json", here), JSON.stringify(description, null, 2) + "\n");
for (const name of MODULES) {
  // `Symbol.dispose` is in no library of TypeScript's that is named after a year.
  const types = new URL(`dist/npm/${name}.d.ts`, here);
  writeFileSync(types, `/// <reference lib="esnext.disposable" />\n${readFileSync(types, "utf8")}`);
  writeFileSync(new URL(`dist/npm/${name}.node.js`, here), text("npm/node.js").replaceAll("MODULE", name));
}

// Scripts and style that the page shares with the report of `bake report`.
const shared = (name) => text(`../hullmap-report/src/page/${name}`);
const script = [
  shared("faults.js"),
  shared("arrays.js"),
  shared("gauss.js"),
  shared("webgl.js"),
  ...["samples.js", "view.js", "motion.js", "baker.js", "page.js", "level.js"].map((name) => text(`page/${name}`)),
].join("\n");
const [wasm, baker] = MODULES.map((name) => readFileSync(new URL(`dist/page/${name}_bg.wasm`, here)).toString("base64"));
// `</script` would end the element.
const [bindings, bakerBindings] = MODULES.map((name) => text(`dist/page/${name}.js`).replaceAll("</script", "<\\/script"));
const parts = {
  style: shared("style.css") + text("page/style.css"),
  bindings,
  worker: `${bakerBindings}\n${text("page/worker.js")}`,
  script,
  wasm,
  baker,
  version,
  level: text("page/level.html"),
  licences: ["dist/npm/LICENSE-MIT", "dist/npm/LICENSES-OF-DEPENDENCIES.txt"].map(text).join("\n").replaceAll("&", "&amp;").replaceAll("<", "&lt;"),
};
const page = text("page/index.html").replace(/\{\{(\w+)\}\}/g, (_, name) => parts[name]);
writeFileSync(new URL("dist/hullmap.html", here), page);
