// Every node of the scene with its controls, which are those of the program's own window.

const panel = document.querySelector("#controls");
const GROUPS = { param: "Parameters", camera: "Cameras", render: "Picture", sky: "Light", sun: "Light", point: "Light", material: "Materials", object: "Objects", declaration: "Shapes", field: "Fields" };

let read;
let write;
let gesture = 1;
/** Paths of the nodes that are open, as JSON. */
const open = new Set();
let shown = "";

/** `reader` returns the controls of a path; `writer` sets one, and fails with the reason of a refusal. */
export function connect(reader, writer) {
  [read, write] = [reader, writer];
}

/** Shows an outline. Nodes stay open while their paths do. */
export function show(outline) {
  const structure = JSON.stringify(outline);
  if (structure === shown) return refresh();
  shown = structure;
  const groups = new Map();
  for (const node of outline) {
    const group = GROUPS[node.kind];
    if (group) groups.set(group, [...(groups.get(group) ?? []), node]);
  }
  const order = [...new Set(Object.values(GROUPS))].filter((name) => groups.has(name));
  panel.replaceChildren(...order.flatMap((name) => [heading(name), ...groups.get(name).map((node) => details(node, name === "Parameters"))]));
}

/** Reads the controls of open nodes again, but not those that someone is dragging. */
function refresh() {
  for (const box of panel.querySelectorAll("details[open] > .own")) {
    if (!box.contains(document.activeElement)) fill(box);
  }
}

function heading(name) {
  const title = document.createElement("h3");
  title.textContent = name;
  return title;
}

function details(node, isOpen) {
  const box = document.createElement("details");
  const path = JSON.stringify(node.path);
  const title = document.createElement("summary");
  title.append(node.title, " ");
  if (node.title !== node.word) title.append(Object.assign(document.createElement("small"), { textContent: node.word }));
  const own = document.createElement("div");
  own.className = "own";
  own.dataset.path = path;
  box.append(title, own, ...node.children.map((child) => details(child, false)));
  box.addEventListener("toggle", () => {
    if (box.open) open.add(path);
    else open.delete(path);
    if (box.open && !own.firstChild) fill(own);
  });
  box.open = isOpen || open.has(path);
  return box;
}

async function fill(own) {
  try {
    const controls = await read(JSON.parse(own.dataset.path));
    own.replaceChildren(...controls.map((control) => row(own, control)));
  } catch {
    // The node is gone; the next outline is without it.
  }
}

function row(own, control) {
  const line = document.createElement("label");
  line.className = "control";
  line.title = control.doc;
  const name = document.createElement("span");
  name.textContent = control.label;
  const parts = document.createElement("span");
  parts.className = "parts";
  const set = async (value, step) => {
    line.nextElementSibling?.matches(".refusal") && line.nextElementSibling.remove();
    try {
      await write(JSON.parse(own.dataset.path), control.key, value, step);
    } catch (error) {
      const refusal = Object.assign(document.createElement("p"), { className: "refusal", textContent: error.message });
      line.after(refusal);
    }
  };
  parts.append(...inputs(control, set));
  line.append(name, parts);
  return line;
}

function inputs(control, set) {
  const { kind, value } = control;
  if (value?.formulas) return [textInput(value.formulas.join("; "), (text) => set({ formulas: text.split(";").map((part) => part.trim()) }, ++gesture))];
  switch (kind.type) {
    case "number": return numberInputs(control, set);
    case "triple": return tripleInputs(control, set);
    case "colour": return colourInputs(control, set);
    case "choice": return [choiceInput(kind.choices, value, false, set)];
    case "material": return [choiceInput(kind.choices, value, !control.required, set)];
    case "flag": return [flagInput(value, set)];
    case "size": return sizeInputs(value ?? control.initial, set);
    default: return [textInput(value ?? "", (text) => set(text, ++gesture))];
  }
}

function numberInput(value, set) {
  const input = Object.assign(document.createElement("input"), { type: "number", step: "any", value: value === null ? "" : short(value) });
  input.addEventListener("change", () => set(input.value === "" ? null : Number(input.value), ++gesture));
  return input;
}

function numberInputs({ kind, value, initial, unit }, set) {
  const [low, high] = kind.soft;
  const toSlider = kind.logarithmic && low > 0 ? Math.log : (number) => number;
  const ofSlider = kind.logarithmic && low > 0 ? Math.exp : (number) => number;
  const slider = Object.assign(document.createElement("input"), {
    type: "range", min: toSlider(low), max: toSlider(high), step: kind.whole ? 1 : (toSlider(high) - toSlider(low)) / 500,
  });
  slider.value = toSlider(value ?? initial ?? low);
  const number = numberInput(value, set);
  slider.addEventListener("pointerdown", () => (gesture += 1));
  slider.addEventListener("input", () => {
    const chosen = kind.whole ? Math.round(ofSlider(slider.value)) : short(ofSlider(Number(slider.value)));
    number.value = chosen;
    set(Number(chosen), gesture);
  });
  return unit ? [slider, number, unit] : [slider, number];
}

function tripleInputs({ value, initial }, set) {
  const now = value ?? initial ?? [0, 0, 0];
  return now.map((part, k) => numberInput(part, (number) => set((now[k] = number ?? 0, [...now]), ++gesture)));
}

function sizeInputs(value, set) {
  const now = [...value];
  return now.map((part, k) => numberInput(part, (number) => set((now[k] = Math.round(number ?? 1), [...now]), ++gesture)));
}

/** A colour of unit peak and a factor, because radiance exceeds 1. */
function colourInputs({ kind, value, initial }, set) {
  const now = value ?? initial ?? [0.5, 0.5, 0.5];
  const peak = Math.max(...now);
  const scale = kind.max > 1 && peak > 0 ? peak : 1;
  const input = Object.assign(document.createElement("input"), { type: "color", value: hex(now.map((channel) => channel / scale)) });
  const factor = kind.max > 1 ? [numberInput(scale, (number) => set(linear(input.value).map((channel) => channel * (number ?? 1)), ++gesture))] : [];
  input.addEventListener("pointerdown", () => (gesture += 1));
  input.addEventListener("input", () => set(linear(input.value).map((channel) => channel * (factor[0] ? Number(factor[0].value) : 1)), gesture));
  return [input, ...factor];
}

function choiceInput(choices, value, mayBeNone, set) {
  const input = document.createElement("select");
  if (mayBeNone || value === null) input.append(new Option("—", ""));
  input.append(...choices.map((choice) => new Option(choice, choice)));
  input.value = value ?? "";
  input.addEventListener("change", () => set(input.value || null, ++gesture));
  return input;
}

function flagInput(value, set) {
  const input = Object.assign(document.createElement("input"), { type: "checkbox", checked: value === true });
  input.addEventListener("change", () => set(input.checked, ++gesture));
  return input;
}

function textInput(value, set) {
  const input = Object.assign(document.createElement("input"), { type: "text", value });
  input.addEventListener("change", () => set(input.value));
  return input;
}

function short(number) {
  return Number(Number(number).toPrecision(4));
}

/** sRGB codes of a linear colour, and back (IEC 61966-2-1). */
function hex(colour) {
  const code = (channel) => (channel <= 0.0031308 ? 12.92 * channel : 1.055 * channel ** (1 / 2.4) - 0.055);
  return "#" + colour.map((channel) => Math.round(255 * Math.min(1, Math.max(0, code(channel)))).toString(16).padStart(2, "0")).join("");
}

function linear(code) {
  const channels = [1, 3, 5].map((at) => parseInt(code.slice(at, at + 2), 16) / 255);
  return channels.map((channel) => short(channel <= 0.04045 ? channel / 12.92 : ((channel + 0.055) / 1.055) ** 2.4));
}
