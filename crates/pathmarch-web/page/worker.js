// A thread with an instance of the module of its own: the editor, or a tracer.
import init, { Editor, GpuTracer, Tracer, mount } from "./pathmarch_web.js";

let ready;
let editor;
let tracer;
let gpu;

const tasks = {
  start({ module }) {
    ready = init({ module_or_path: module });
    return ready.then(() => undefined);
  },
  files({ files }) {
    for (const [path, bytes] of files) mount(path, bytes);
  },

  open({ name, text }) {
    editor?.free();
    editor = new Editor(name, text);
    return JSON.parse(editor.state());
  },
  type({ text, gesture }) {
    editor.set_text(text, gesture);
    return JSON.parse(editor.state());
  },
  time({ seconds }) {
    editor.set_time(seconds);
    return JSON.parse(editor.state());
  },
  controls({ path }) {
    return JSON.parse(editor.controls(JSON.stringify(path)));
  },
  set({ path, key, value, gesture }) {
    editor.set(JSON.stringify(path), key, JSON.stringify(value), gesture);
    return { text: editor.text(), ...JSON.parse(editor.state()) };
  },
  camera({ camera }) {
    editor.write_camera(camera);
    return { text: editor.text(), ...JSON.parse(editor.state()) };
  },
  step({ back }) {
    if (back) editor.undo();
    else editor.redo();
    return { text: editor.text(), ...JSON.parse(editor.state()) };
  },

  scene({ name, text, seconds }) {
    tracer ??= new Tracer(name, text);
    tracer.set_text(text, seconds);
  },
  view({ view }) {
    tracer.set_view(view);
  },
  async gpuScene({ name, text, seconds }) {
    gpu ??= await GpuTracer.open(name, text);
    gpu.set_text(text, seconds);
    return gpu.name();
  },
  gpuView({ view }) {
    gpu.set_view(view);
  },
  /** Sums of all samples so far, and last their number. */
  async gpuTrace({ samples, milliseconds }) {
    return { sums: await gpu.trace(samples, milliseconds) };
  },
  trace({ row, rows, first, samples }) {
    const began = performance.now();
    const sums = tracer.trace(row, rows, first, samples);
    return { sums, milliseconds: performance.now() - began };
  },
};

onmessage = async ({ data: { id, task, ...what } }) => {
  try {
    const result = await tasks[task](what);
    postMessage({ id, result }, result?.sums ? [result.sums.buffer] : []);
  } catch (error) {
    // After a panic the instance must not be used any more.
    postMessage({ id, error: error.message ?? String(error), fatal: error instanceof WebAssembly.RuntimeError });
  }
};
