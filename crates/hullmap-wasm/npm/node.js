// The entry of the package in Node, whose `fetch` reads no files: `init()` reads the module itself.

import { readFile } from "node:fs/promises";
import load from "./hullmap.js";

export * from "./hullmap.js";

export default async function init(source) {
  return load(source ?? { module_or_path: await readFile(new URL("hullmap_bg.wasm", import.meta.url)) });
}
