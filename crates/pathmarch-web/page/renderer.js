// The picture: distributes rectangles of samples among tracers, and shows their sums.
//
// While the camera moves, it is the preview without noise, at a size that keeps up. At rest it is path-traced at full size, and
// fades in over the last preview.
//
// A thread with the GPU traces whole pictures, if there is one; else all others trace rows of them.
import { Picture } from "./pathmarch_web.js";
import { Thread } from "./thread.js";

/** Milliseconds that a frame of the moving preview may take. */
const FRAME_TIME = 90;
/** Milliseconds of a task: short enough to react, long enough to be worth a message. */
const TASK_TIME = 45;
/** Milliseconds without motion after which the traced picture starts. */
const REST = 160;
/** Milliseconds between two pictures of the GPU. */
const GPU_TIME = 150;
/** Samples after which the traced picture hides the preview. */
const FADE = 12;

export class Renderer {
  #module;
  #threads = [];
  #files = [];
  #canvases;
  #changed;
  /** What is shown: name, text, seconds; hash, size, samples and tone curve of the scene; camera. */
  #scene = null;
  #camera = null;
  #size = [1, 1];
  /** Rises with every change of scene or view. */
  #version = 0;
  #sceneVersion = 0;
  #frame = null;
  #queue = [];
  #restTimer = 0;
  #moving = true;
  /** Milliseconds that a thread takes for a pixel, by mode. */
  #cost = { preview: 0.004, path: 0.01 };
  #failure = null;
  /** Thread with the GPU; null without one. */
  #gpu = null;
  #gpuName = "";
  #gpuIsBusy = false;
  #gpuScene = -1;
  /** Reason why the GPU is not used. */
  #gpuNotice = "";
  #backend = "auto";

  /** `canvases`: those of the preview and of the traced picture. `changed` is called with the state. */
  constructor(module, threads, canvases, changed) {
    this.#module = module;
    this.#canvases = canvases;
    this.#changed = changed;
    for (let k = 0; k < threads; k++) this.#threads.push({ thread: new Thread(module), scene: -1, view: "", busy: false });
    document.addEventListener("visibilitychange", () => this.#feed());
  }

  /** Gives files to all tracers, which scenes may name. */
  mount(files) {
    this.#files.push(...files);
    const threads = [...this.#threads.map(({ thread }) => thread), ...(this.#gpu ? [this.#gpu] : [])];
    return Promise.all(threads.map((thread) => thread.ask("files", { files })));
  }

  /** Chooses what renders: "auto", "gpu" or "cpu". Only a real GPU is faster than the workers. */
  async choose(backend) {
    this.#backend = backend;
    this.#gpu?.stop();
    this.#gpu = null;
    this.#gpuNotice = "";
    if (backend !== "cpu") {
      const adapter = await navigator.gpu?.requestAdapter().catch(() => null);
      const { vendor, architecture, isFallbackAdapter } = adapter?.info ?? {};
      const isSoftware = isFallbackAdapter || /swiftshader|llvmpipe/i.test(architecture);
      if (adapter && (backend === "gpu" || !isSoftware)) this.#openGpu([vendor, architecture].filter(Boolean).join(" "));
      else if (backend === "gpu") this.#gpuNotice = "this browser has no WebGPU";
    }
    if (this.#scene) this.#move();
  }

  #openGpu(name) {
    this.#gpuName = name;
    this.#gpu = new Thread(this.#module);
    [this.#gpuScene, this.#gpuIsBusy] = [-1, false];
    this.#gpu.ask("files", { files: this.#files }).catch(() => {});
  }

  /** Shows another scene, at the same size. */
  show(scene, camera) {
    this.#scene = scene;
    this.#camera = camera;
    this.#sceneVersion += 1;
    this.#failure = null;
    // What it refused was another scene.
    if (this.#gpuNotice && this.#backend !== "cpu" && this.#gpuName && !this.#gpu) this.#openGpu(this.#gpuName);
    this.#move();
  }

  /** Looks from another camera, JSON. */
  look(camera) {
    this.#camera = camera;
    this.#move();
  }

  /** Changes the size of the traced picture. */
  resize(size) {
    if (size[0] === this.#size[0] && size[1] === this.#size[1]) return;
    this.#size = size;
    if (this.#scene) this.#move();
  }

  /** Traced picture so far; null while it moves. */
  get picture() {
    return this.#frame?.mode === "path" && this.#frame.picture.samples() > 0 ? this.#frame.picture : null;
  }

  #move() {
    this.#version += 1;
    this.#moving = true;
    clearTimeout(this.#restTimer);
    this.#restTimer = setTimeout(() => this.#rest(), REST);
    // A preview frame that is under way is finished first, so that fast motion shows something.
    if (this.#frame?.mode !== "preview") this.#begin("preview");
    this.#report();
  }

  #rest() {
    this.#moving = false;
    if (this.#frame?.mode !== "preview" || this.#frame.isDone) this.#begin("path");
  }

  /** Starts a frame: one sample of the preview, or all of the traced picture. */
  #begin(mode) {
    if (!this.#scene) return;
    this.#frame?.picture.free();
    const size = mode === "preview" ? this.#previewSize() : this.#size;
    const camera = JSON.parse(this.#camera);
    const exposure = camera.auto_exposure ? undefined : camera.exposure;
    this.#frame = {
      mode, size, version: this.#version, sceneVersion: this.#sceneVersion, sample: 0, row: 0, done: 0, isDone: false,
      began: performance.now(),
      picture: new Picture(...size, this.#scene.tonemap, exposure, this.#scene.hash),
      view: JSON.stringify({ camera: JSON.parse(this.#camera), size, mode }),
    };
    this.#feed();
  }

  /** Size of a preview that all threads trace within the time of a frame. */
  #previewSize() {
    const [width, height] = this.#size;
    if (this.#gpu) return [width, height];
    const pixels = (FRAME_TIME * this.#threads.length) / this.#cost.preview;
    const scale = Math.min(1, Math.sqrt(pixels / (width * height)));
    return [width, height].map((side) => Math.max(1, Math.round(side * scale)));
  }

  /** Next rows of the present frame; null if all are given out. */
  #nextTask() {
    const frame = this.#frame;
    const limit = frame.mode === "preview" ? 1 : this.#scene.samples;
    if (frame.sample >= limit) return null;
    const [width, height] = frame.size;
    const even = Math.ceil(height / (2 * this.#threads.length));
    const affordable = Math.round(TASK_TIME / (this.#cost[frame.mode] * width) / 8) * 8;
    const rows = Math.min(height - frame.row, Math.max(8, Math.min(even, affordable)));
    const task = { row: frame.row, rows, first: frame.sample, samples: 1 };
    frame.row += rows;
    if (frame.row >= height) [frame.row, frame.sample] = [0, frame.sample + 1];
    return task;
  }

  /** Gives tasks to idle threads. */
  #feed() {
    if (!this.#frame || this.#failure || document.hidden) return;
    if (this.#gpu) return void this.#runGpu(this.#gpu);
    for (const tracer of this.#threads) {
      if (tracer.busy) continue;
      const task = this.#nextTask();
      if (!task) return;
      this.#run(tracer, this.#frame, task);
    }
  }

  /** Renders frames on the GPU until all samples are done. */
  async #runGpu(thread) {
    if (this.#gpuIsBusy) return;
    this.#gpuIsBusy = true;
    let view = "";
    try {
      while (this.#gpu === thread && !document.hidden) {
        const frame = this.#frame;
        const samples = frame.mode === "preview" ? 1 : this.#scene.samples;
        if (frame.done >= samples * frame.size[1]) break;
        if (this.#gpuScene !== frame.sceneVersion) {
          const { name, text, seconds } = this.#scene;
          await thread.ask("gpuScene", { name, text, seconds });
          [this.#gpuScene, view] = [frame.sceneVersion, ""];
        }
        if (view !== frame.view || frame.done === 0) await thread.ask("gpuView", { view: frame.view });
        view = frame.view;
        const { sums } = await thread.ask("gpuTrace", { samples, milliseconds: GPU_TIME });
        if (frame !== this.#frame) continue;
        const done = sums.at(-1);
        frame.picture.replace(sums.subarray(0, -1), done);
        frame.done = done * frame.size[1];
        this.#progress(frame, done);
      }
    } catch (error) {
      this.#loseGpu(thread, error);
    }
    if (this.#gpu === thread) this.#gpuIsBusy = false;
    else this.#feed();
  }

  /** Goes on with the workers; the next scene tries the GPU again. */
  #loseGpu(thread, error) {
    if (this.#gpu !== thread) return;
    thread.stop();
    this.#gpu = null;
    this.#gpuNotice = error.message;
    this.#begin(this.#frame.mode);
    this.#report();
  }

  async #run(tracer, frame, task) {
    tracer.busy = true;
    try {
      if (tracer.scene !== frame.sceneVersion) {
        tracer.scene = frame.sceneVersion;
        const { name, text, seconds } = this.#scene;
        tracer.view = "";
        await tracer.thread.ask("scene", { name, text, seconds });
      }
      if (tracer.view !== frame.view) {
        tracer.view = frame.view;
        await tracer.thread.ask("view", { view: frame.view });
      }
      const { sums, milliseconds } = await tracer.thread.ask("trace", task);
      const cost = milliseconds / (task.rows * frame.size[0] * task.samples);
      this.#cost[frame.mode] += 0.3 * (cost - this.#cost[frame.mode]);
      if (frame === this.#frame) this.#take(frame, task, sums);
    } catch (error) {
      this.#recover(tracer, frame, error);
    }
    tracer.busy = false;
    this.#feed();
  }

  /** Replaces a broken thread, and shows the reason if the frame is still the present one. */
  #recover(tracer, frame, error) {
    if (tracer.thread.isBroken) {
      tracer.thread = new Thread(this.#module);
      tracer.scene = -1;
      tracer.thread.ask("files", { files: this.#files }).catch(() => {});
    }
    if (frame.sceneVersion !== this.#sceneVersion) return;
    this.#failure = `This scene cannot be rendered here: ${error.message}`;
    this.#report();
  }

  #take(frame, task, sums) {
    frame.picture.add(task.row, sums, task.samples);
    frame.done += task.rows;
    this.#progress(frame, Math.floor(frame.done / frame.size[1]));
  }

  /** Shows a frame of which this many samples are done, and starts the next one. */
  #progress(frame, samples) {
    if (frame.mode === "preview") {
      if (samples < 1) return;
      frame.isDone = true;
      this.#draw(0, frame);
      this.#canvases[1].style.opacity = 0;
      if (frame.version !== this.#version) this.#begin("preview");
      else if (!this.#moving) this.#begin("path");
      return;
    }
    const now = performance.now();
    const isComplete = samples >= this.#scene.samples;
    if (samples >= 1 && (isComplete || now - (frame.drawn ?? 0) > Math.min(1000, 60 + 4 * samples))) {
      frame.drawn = now;
      this.#draw(1, frame);
      this.#canvases[1].style.opacity = Math.min(1, samples / FADE);
      this.#report();
    }
  }

  #draw(layer, frame) {
    const canvas = this.#canvases[layer];
    const [width, height] = frame.size;
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = frame.size;
    const pixels = new Uint8ClampedArray(frame.picture.rgba());
    canvas.getContext("2d").putImageData(new ImageData(pixels, width, height), 0, 0);
  }

  #renderer() {
    if (this.#gpu) return `GPU (${this.#gpuName})`;
    const notice = this.#gpuNotice && ` (GPU: ${this.#gpuNotice})`;
    return `CPU, ${this.#threads.length} threads${notice}`;
  }

  #report() {
    const frame = this.#frame;
    const samples = frame?.mode === "path" ? frame.picture.samples() : 0;
    this.#changed({
      failure: this.#failure, samples, goal: this.#scene?.samples, size: this.#size, renderer: this.#renderer(),
      seconds: frame ? (performance.now() - frame.began) / 1000 : 0,
    });
  }
}
