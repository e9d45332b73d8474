// The page: connects text, controls, picture and gallery.
import init from "./pathmarch_web.js";
import * as gallery from "./gallery.js";
import * as inspector from "./inspector.js";
import { Renderer } from "./renderer.js";
import { linkTo, sceneOf } from "./share.js";
import * as source from "./source.js";
import { Thread } from "./thread.js";
import { Viewport } from "./viewport.js";

/** Example that opens first. */
const FIRST = "ten-lines";
/** Key of the text that is kept in the browser. */
const KEPT = "pathmarch:scene";
/** Tracers at most: each has a copy of the scene. */
const MAX_THREADS = 16;
/** Pixels of a picture at most: larger ones are for the program, which has more memory. */
const MAX_PIXELS = 3840 * 2160;

const $ = (selector) => document.querySelector(selector);
const viewportElement = $("#viewport");

let editor;
let renderer;
let viewport;
/** Name of the text, by which files are found. */
let name = "scene.kdl";
let state = null;
let seconds = 0;
/** True while the view is another than the scene's first camera. */
let hasMoved = false;
let module;

async function start() {
  module = await WebAssembly.compileStreaming(fetch("pathmarch_web_bg.wasm"));
  await init({ module_or_path: module });
  editor = new Thread(module);
  const threads = Math.max(1, Math.min(MAX_THREADS, navigator.hardwareConcurrency ?? 2));
  renderer = new Renderer(module, threads, [$("#preview"), $("#traced")], showProgress);
  viewport = new Viewport(viewportElement, (camera) => {
    hasMoved = true;
    renderer.look(camera);
    showViewBar();
  });
  inspector.connect((path) => editor.ask("controls", { path }), setControl);
  source.onType(typed);
  connectButtons();
  new ResizeObserver(resize).observe(viewportElement);
  await Promise.all([renderer.choose("auto"), openFirst()]);
  gallery.fill(openExample);
}

/** The scene of the address, else the text that was edited last, else an example. */
async function openFirst() {
  const shared = await sceneOf(location.hash);
  if (shared) return open(shared.name ?? "scene.kdl", shared.text, shared.camera);
  if (location.hash.startsWith("#scene=")) say("The scene in this address is damaged; copy the whole link.");
  const example = location.hash.startsWith("#gallery=") && (await gallery.load(decodeURIComponent(location.hash.slice(9))));
  if (example) return open(example.name, example.text);
  const kept = JSON.parse(localStorage.getItem(KEPT) ?? "null");
  if (kept?.text && location.hash === "") return open(kept.name, kept.text);
  const first = await gallery.load(FIRST);
  return open(first.name, first.text);
}

async function openExample(file) {
  const example = await gallery.load(file);
  await open(example.name, example.text);
  history.replaceState(null, "", `#gallery=${encodeURIComponent(file)}`);
}

/** Opens another text. */
async function open(newName, text, camera) {
  [name, seconds, hasMoved] = [newName, 0, false];
  source.show(text);
  await mountFiles(text);
  await take(editor.ask("open", { name, text }), text);
  if (camera && state?.scene) {
    viewport.camera = camera;
    hasMoved = true;
    renderer.look(camera);
    showViewBar();
  }
}

/** Gives files that a text names to all threads. */
async function mountFiles(text) {
  const files = await gallery.filesOf(text).catch(() => []);
  if (files.length) await Promise.all([editor.ask("files", { files }), renderer.mount(files)]);
}

let pendingText = null;
let isReading = false;

/** Reads what was typed last; never two texts at once. */
async function typed(text, gesture) {
  keep(text);
  pendingText = { text, gesture };
  if (isReading) return;
  isReading = true;
  while (pendingText) {
    const next = pendingText;
    pendingText = null;
    await mountFiles(next.text);
    await take(editor.ask("type", next), next.text);
  }
  isReading = false;
}

/** Keeps an edited text in the browser, and out of the address of another. */
function keep(text) {
  try {
    localStorage.setItem(KEPT, JSON.stringify({ name, text }));
  } catch {
    // Without storage the text is in the page alone.
  }
  if (location.hash) history.replaceState(null, "", location.pathname + location.search);
}

async function setControl(path, key, value, gesture) {
  await take(editor.ask("set", { path, key, value, gesture }));
}

/** Takes the state of the editor; a changed text is shown. Refusals are for the caller. */
async function take(answer, ofText) {
  let next;
  try {
    next = await answer;
  } catch (error) {
    if (!editor.isBroken) throw error;
    return restart(error);
  }
  if (next.text !== undefined) {
    source.show(next.text);
    keep(next.text);
  }
  const text = next.text ?? ofText ?? source.text();
  source.report(next.reports, text);
  $("#undo").disabled = !next.undo;
  $("#redo").disabled = !next.redo;
  const before = state?.scene;
  state = next;
  inspector.show(next.outline);
  if (next.scene) showScene(next.scene, text, before);
  else say(next.reports.length === 1 ? "The text has a mistake." : `The text has ${next.reports.length} mistakes.`);
}

/** A text that breaks the module itself, such as one that exhausts its memory. */
async function restart(error) {
  editor = new Thread(module);
  say(`This text cannot be read here: ${error.message}`);
  source.report([], source.text());
  state = null;
  await editor.ask("open", { name, text: "" });
}

let shownText = null;

function showScene(scene, text, before) {
  const camera = JSON.stringify(scene.cameras[0]);
  const changesCamera = !before || JSON.stringify(before.cameras[0]) !== camera;
  if (!hasMoved || (changesCamera && before)) {
    hasMoved &&= !changesCamera;
    viewport.camera = camera;
  }
  say("");
  showViewBar();
  resize();
  const key = JSON.stringify([text, seconds, name]);
  if (key !== shownText) {
    shownText = key;
    renderer.show({ name, text, seconds, hash: scene.hash, samples: scene.samples, tonemap: scene.tonemap }, viewport.camera);
  }
}

/** Fits the picture into the page with the proportions of the scene. */
function resize() {
  const size = state?.scene?.size;
  if (!size) return;
  const fit = Math.min(viewportElement.clientWidth / size[0], viewportElement.clientHeight / size[1]);
  const shown = size.map((side) => Math.max(1, Math.round(side * fit)));
  for (const canvas of [$("#preview"), $("#traced")]) [canvas.style.width, canvas.style.height] = shown.map((side) => `${side}px`);
  const choice = $("#size").value;
  const wanted = choice === "scene" ? size : shown;
  const scale = Math.min(choice === "half" ? 0.5 : 1, Math.sqrt(MAX_PIXELS / (wanted[0] * wanted[1])));
  renderer.resize(wanted.map((side) => Math.max(1, Math.round(side * scale))));
}

function showProgress({ failure, samples, goal, size, renderer: used, seconds }) {
  if (failure) say(failure);
  const done = samples >= goal ? "done" : `${samples} of ${goal} samples`;
  $("#status").textContent = `${size[0]}×${size[1]} · ${samples ? done : "moving"} · ${seconds.toFixed(1)} s · ${used}`;
  document.body.dataset.samples = samples;
}

function showViewBar() {
  $("#reset-view").hidden = $("#write-view").hidden = !hasMoved;
  $("#time").hidden = !state?.scene?.animated;
}

function say(message) {
  $("#message").textContent = message;
  $("#message").hidden = !message;
}

function connectButtons() {
  $("#show-gallery").addEventListener("click", gallery.show);
  $("#undo").addEventListener("click", () => take(editor.ask("step", { back: true })));
  $("#redo").addEventListener("click", () => take(editor.ask("step", { back: false })));
  $("#share").addEventListener("click", share);
  $("#size").addEventListener("change", resize);
  $("#backend").addEventListener("change", () => renderer.choose($("#backend").value));
  $("#png").addEventListener("click", () => savePicture("png", "image/png"));
  $("#exr").addEventListener("click", () => savePicture("exr", "image/x-exr"));
  $("#kdl").addEventListener("click", () => save(new Blob([source.text()], { type: "text/plain" }), "kdl"));
  $("#reset-view").addEventListener("click", resetView);
  $("#write-view").addEventListener("click", writeView);
  $("#time input").addEventListener("input", setTime);
  for (const tab of document.querySelectorAll("[role=tab]")) tab.addEventListener("click", () => showTab(tab));
  document.addEventListener("keydown", shortcuts);
  document.addEventListener("click", (event) => event.target.closest("#download div, #viewport, aside") && ($("#download").open = false));
  window.addEventListener("hashchange", openFirst);
}

function shortcuts(event) {
  if (!(event.ctrlKey || event.metaKey) || !/^[zy]$/i.test(event.key)) return;
  event.preventDefault();
  take(editor.ask("step", { back: event.key.toLowerCase() === "z" && !event.shiftKey }));
}

function showTab(tab) {
  for (const other of document.querySelectorAll("[role=tab]")) {
    other.setAttribute("aria-selected", String(other === tab));
    $(`#${other.dataset.panel}`).hidden = other !== tab;
  }
}

function resetView() {
  hasMoved = false;
  viewport.camera = JSON.stringify(state.scene.cameras[0]);
  renderer.look(viewport.camera);
  showViewBar();
}

async function writeView() {
  hasMoved = false;
  await take(editor.ask("camera", { camera: viewport.camera }));
}

async function setTime() {
  seconds = Number($("#time input").value);
  $("#time output").textContent = `${seconds.toFixed(2)} s`;
  await take(editor.ask("time", { seconds }));
}

async function share() {
  const link = await linkTo({ name, text: source.text(), camera: hasMoved ? viewport.camera : undefined });
  history.replaceState(null, "", link);
  try {
    await navigator.clipboard.writeText(link);
    $("#share").textContent = "Link copied";
  } catch {
    $("#share").textContent = "Link is in the address";
  }
  setTimeout(() => ($("#share").textContent = "Share"), 2000);
}

function savePicture(kind, type) {
  const picture = renderer.picture;
  if (!picture) return say("The picture has no samples yet; wait a moment.");
  save(new Blob([picture[kind]()], { type }), kind);
}

function save(blob, extension) {
  const base = name.slice(name.lastIndexOf("/") + 1).replace(/\.kdl$/, "");
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: `${base}.${extension}` });
  link.click();
  URL.revokeObjectURL(link.href);
}

start().catch((error) => say(`The page could not start: ${error.message}`));
