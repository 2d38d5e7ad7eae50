// The entry of the module in Node, whose `fetch` reads no files: `init()` reads the module itself.

import { readFile } from "node:fs/promises";
import load from "./MODULE.js";

export * from "./MODULE.js";

export default async function init(source) {
  return load(source ?? { module_or_path: await readFile(new URL("MODULE_bg.wasm", import.meta.url)) });
}
