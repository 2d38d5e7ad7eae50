// Bakes in a worker, so that the page stays responsive.

/** A failure of the baker that does not depend on the file. */
class BakerEnded extends Error {}

/** The bake was cancelled. */
class BakeCancelled extends Error {}

class Baker {
  #source;
  #worker = null;
  /** Why the worker does not run in this browser. */
  #failure = null;
  /** Bakes without an answer, by number: what was posted, and the functions that hear of it. */
  #open = new Map();
  #count = 0;

  /** `source` is the text of the worker; `module` are the bytes of the baker. */
  constructor(source, module) {
    this.#source = source;
    this.module = module;
    this.#start();
  }

  #start() {
    // A page that was opened from disk may not load a worker from a file, but from its own text.
    const url = URL.createObjectURL(new Blob([this.#source], { type: "text/javascript" }));
    const worker = new Worker(url);
    URL.revokeObjectURL(url);
    // Ignore what a worker posted before it was ended.
    worker.onmessage = ({ data }) => worker === this.#worker && this.#answer(data);
    worker.onerror = (event) => {
      event.preventDefault();
      this.#failure = new BakerEnded(event.message);
      this.#rejectAll(this.#failure);
    };
    this.#worker = worker;
    worker.postMessage({ module: this.module });
  }

  /**
   * Does what the worker has under this name: `mesh`, `level` or `map`. `hear` is called with the share
   * that is done.
   */
  run(kind, words, hear) {
    return new Promise((resolve, reject) => {
      if (this.#failure) return reject(this.#failure);
      const id = this.#count++, job = { id, kind, words };
      this.#open.set(id, { job, resolve, reject, hear });
      this.#worker.postMessage(job);
    });
  }

  /** Ends all bakes. A decomposition does not look for messages, so its worker ends with it. */
  cancel() {
    this.#worker.terminate();
    this.#rejectAll(new BakeCancelled("cancelled"));
    this.#start();
  }

  #answer({ id, share, answer, ended, message }) {
    const { resolve, reject, hear } = this.#open.get(id);
    if (share !== undefined) return hear?.(share);
    this.#open.delete(id);
    if (answer) return resolve(answer);
    reject(ended ? new BakerEnded(message) : new Error(message));
    if (!ended) return;
    // A new worker has new memory. It bakes what the old one has not begun.
    this.#worker.terminate();
    this.#start();
    for (const { job } of this.#open.values()) this.#worker.postMessage(job);
  }

  #rejectAll(error) {
    for (const { reject } of this.#open.values()) reject(error);
    this.#open.clear();
  }
}
