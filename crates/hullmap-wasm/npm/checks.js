// Checks that the script of wasm-bindgen leaves out. hullmap-bindgen puts them into it.

/** Stands for the module's functions before `init`. */
function notLoaded() {
  return new Proxy({}, {
    get() {
      throw new Error("the module is not loaded: await init(), its default export, first");
    },
  });
}

/** The numbers of an array, or of an attribute of three.js, whose own array may interleave others. */
function numbersOf(arg) {
  if (typeof arg?.length === "number") return arg;
  const axes = { 1: ["getX"], 3: ["getX", "getY", "getZ"] }[arg?.itemSize];
  if (!axes || typeof arg.getX !== "function") {
    throw new TypeError("expected an array of numbers, such as [0, 0, 1], or an attribute of three.js with 1 or 3 numbers per item");
  }
  const numbers = new Float64Array(axes.length * arg.count);
  for (let i = 0, next = 0; i < arg.count; i++) for (const axis of axes) numbers[next++] = arg[axis](i);
  return numbers;
}

/** The message of an error of wasm-bindgen, with a remedy. */
function withRemedy(message) {
  if (message !== "null pointer passed to rust") return message;
  return "the object was freed: call free() only after its last use";
}
