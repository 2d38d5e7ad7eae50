// The worker of the page: bakes files one after the other, on a thread of its own. The bindings of
// wasm-bindgen stand before this text.
onmessage = ({ data: { module, id, file, bytes, options } }) => {
  if (module) {
    wasm_bindgen.initSync({ module });
    return;
  }
  try {
    const start = performance.now();
    const baked = wasm_bindgen.bake(file, bytes, options);
    const { pack, positions, triangles, notes, warnings } = baked;
    baked.free();
    const answer = { pack, positions, triangles, notes, warnings, millis: performance.now() - start };
    postMessage({ id, answer }, [pack.buffer, positions.buffer, triangles.buffer]);
  } catch (error) {
    // After a trap, or without memory, the module cannot be used again.
    const ended = error instanceof WebAssembly.RuntimeError || error instanceof RangeError;
    postMessage({ id, ended, message: error && error.message ? error.message : String(error) });
  }
};
