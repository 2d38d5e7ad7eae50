// The worker of the page: bakes files one after the other, on a thread of its own. The bindings of
// wasm-bindgen stand before this text.
{
  /** The values of an object of WebAssembly, which is freed. */
  const taken = (baked, keys) => {
    const values = Object.fromEntries(keys.map((key) => [key, baked[key]]));
    baked.free();
    return values;
  };
  const WORK = {
    mesh: (hear, file, bytes, options) => taken(wasm_bindgen.bake(file, bytes, options, hear), ["pack", "positions", "triangles", "notes", "warnings"]),
    level: (_, file, bytes, options) => taken(wasm_bindgen.bakeLevel(file, bytes, options), ["bytes", "notes", "warnings"]),
    map: (_, pack, hull, resolution) => wasm_bindgen.gaussMap(pack, hull, resolution),
  };
  onmessage = ({ data: { module, id, kind, words } }) => {
    if (module) {
      wasm_bindgen.initSync({ module });
      return;
    }
    try {
      const start = performance.now();
      const answer = WORK[kind]((share) => postMessage({ id, share }), ...words);
      postMessage({ id, answer: { ...answer, millis: performance.now() - start } });
    } catch (error) {
      // After a trap, or without memory, the module cannot be used again.
      const ended = error instanceof WebAssembly.RuntimeError || error instanceof RangeError;
      postMessage({ id, ended, message: error && error.message ? error.message : String(error) });
    }
  };
}
