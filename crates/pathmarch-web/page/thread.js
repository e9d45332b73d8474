// A worker that answers with promises.

export class Thread {
  #worker = new Worker(new URL("worker.js", import.meta.url), { type: "module" });
  #waiting = new Map();
  #next = 0;

  constructor(module) {
    this.#worker.onmessage = ({ data }) => this.#answer(data);
    this.#worker.onerror = (event) => this.#fail(event.message ?? "a worker did not start");
    this.ask("start", { module }).catch(() => {});
  }

  /** True once a panic or the end of memory has made it useless. */
  isBroken = false;

  /** Number of tasks that have no answer yet. */
  get pending() {
    return this.#waiting.size;
  }

  ask(task, what = {}) {
    return new Promise((resolve, reject) => {
      const id = this.#next++;
      this.#waiting.set(id, { resolve, reject });
      this.#worker.postMessage({ id, task, ...what });
    });
  }

  stop() {
    this.#worker.terminate();
    this.#fail("stopped");
  }

  #answer({ id, result, error, fatal }) {
    const { resolve, reject } = this.#waiting.get(id) ?? {};
    this.#waiting.delete(id);
    if (error === undefined) return resolve?.(result);
    reject?.(new Error(error));
    if (fatal) this.#fail(error);
  }

  #fail(reason) {
    this.isBroken = true;
    for (const { reject } of this.#waiting.values()) reject(new Error(reason));
    this.#waiting.clear();
  }
}
