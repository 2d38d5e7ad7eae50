// Bakes in a worker, so that the page stays responsive.

/** A failure of the baker that does not depend on the file. */
class BakerEnded extends Error {}

class Baker {
  #source;
  #module;
  #worker = null;
  /** Bakes without an answer, by number: what was posted, and the functions of its promise. */
  #open = new Map();
  #count = 0;

  /** `source` is the text of the worker, bindings first; `module` is compiled. */
  constructor(source, module) {
    this.#source = source;
    this.#module = module;
    this.#start();
  }

  /** Without workers, it bakes on the thread of the page, which blocks meanwhile. */
  get hasWorker() {
    return this.#worker !== null;
  }

  #start() {
    try {
      // A page that was opened from disk may not load a worker from a file, but from its own text.
      const url = URL.createObjectURL(new Blob([this.#source], { type: "text/javascript" }));
      const worker = new Worker(url);
      URL.revokeObjectURL(url);
      // Ignore what a worker posted before it was ended.
      worker.onmessage = ({ data }) => worker === this.#worker && this.#answer(data);
      worker.onerror = (event) => {
        event.preventDefault();
        this.#giveUp();
      };
      this.#worker = worker;
      worker.postMessage({ module: this.#module });
    } catch {
      this.#giveUp();
    }
  }

  /** Bakes a mesh file: pack, positions, triangles, notes, warnings and milliseconds. */
  bake(file, bytes, options) {
    return new Promise((resolve, reject) => {
      const id = this.#count++;
      const job = { id, file, bytes, options };
      this.#open.set(id, { job, resolve, reject });
      if (this.#worker) this.#worker.postMessage(job);
      else this.#here(id);
    });
  }

  #answer({ id, answer, ended, message }) {
    const { resolve, reject } = this.#open.get(id);
    this.#open.delete(id);
    if (answer) return resolve(answer);
    reject(ended ? new BakerEnded(message) : new Error(message));
    if (!ended) return;
    // A new worker has new memory. It bakes what the old one has not begun.
    this.#worker.terminate();
    this.#start();
    if (this.#worker) for (const { job } of this.#open.values()) this.#worker.postMessage(job);
  }

  /** The worker does not run in this browser. */
  #giveUp() {
    this.#worker?.terminate();
    this.#worker = null;
    for (const id of [...this.#open.keys()]) this.#here(id);
  }

  /** Bakes on this thread, after the message is on the screen. */
  #here(id) {
    setTimeout(() => {
      const { job, resolve, reject } = this.#open.get(id);
      this.#open.delete(id);
      try {
        const start = performance.now();
        const baked = wasm_bindgen.bake(job.file, job.bytes, job.options);
        const { pack, positions, triangles, notes, warnings } = baked;
        baked.free();
        resolve({ pack, positions, triangles, notes, warnings, millis: performance.now() - start });
      } catch (error) {
        reject(error);
      }
    }, 30);
  }
}
