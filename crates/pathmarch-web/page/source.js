// The text with its mistakes underlined.

const area = document.querySelector("#area");
const underlines = document.querySelector("#underlines");
const list = document.querySelector("#mistakes");

let reports = [];
/** Text that the reports are of. */
let reported = "";
let gesture = 1;
let lastKey = 0;

/** Calls `typed` with the text and the step of undo that it belongs to. */
export function onType(typed) {
  area.addEventListener("input", () => {
    const now = performance.now();
    if (now - lastKey > 1500) gesture += 1;
    lastKey = now;
    underline();
    typed(area.value, gesture);
  });
  area.addEventListener("scroll", align);
  area.addEventListener("keydown", indent);
}

export function text() {
  return area.value;
}

/** Shows a text that did not come from typing. */
export function show(text) {
  if (area.value === text) return;
  const { selectionStart, selectionEnd, scrollTop } = area;
  area.value = text;
  area.setSelectionRange(Math.min(selectionStart, text.length), Math.min(selectionEnd, text.length));
  area.scrollTop = scrollTop;
  underline();
}

/** Shows the mistakes of a text. */
export function report(found, ofText) {
  [reports, reported] = [found, ofText];
  underline();
  list.replaceChildren(...found.map(entry));
}

/** Tab and Enter keep the indentation. */
function indent(event) {
  if (event.key === "Tab" && !event.shiftKey && !event.ctrlKey && !event.altKey) {
    event.preventDefault();
    document.execCommand("insertText", false, "    ");
  } else if (event.key === "Enter") {
    const line = area.value.slice(0, area.selectionStart).split("\n").at(-1);
    const blank = /^\s*/.exec(line)[0] + (/\{\s*$/.test(line) ? "    " : "");
    if (!blank) return;
    event.preventDefault();
    document.execCommand("insertText", false, `\n${blank}`);
  }
}

function align() {
  underlines.scrollTop = area.scrollTop;
  underlines.scrollLeft = area.scrollLeft;
}

/** Marks are those of the last report, moved by what was typed since. */
function underline() {
  const text = area.value;
  let start = 0;
  while (start < text.length && text[start] === reported[start]) start += 1;
  let end = 0;
  while (end < text.length - start && end < reported.length - start && text.at(-1 - end) === reported.at(-1 - end)) end += 1;
  const moved = (at) => (at <= start ? at : at >= reported.length - end ? at + text.length - reported.length : start);
  const marks = reports.map(({ span, warning }) => ({ from: moved(span[0]), to: Math.max(moved(span[1]), moved(span[0]) + 1), warning }));
  marks.sort((one, other) => one.from - other.from);
  const parts = [];
  let at = 0;
  for (const { from, to, warning } of marks) {
    if (from < at) continue;
    parts.push(text.slice(at, from));
    const mark = document.createElement("span");
    mark.className = warning ? "odd" : "wrong";
    mark.textContent = text.slice(from, to);
    parts.push(mark);
    at = to;
  }
  // A text that ends with a line break has a line after it.
  parts.push(text.slice(at) + "\n");
  underlines.replaceChildren(...parts);
  align();
}

function entry({ message, label, help, span, line, warning }) {
  const item = document.createElement("li");
  item.className = warning ? "odd" : "wrong";
  const button = document.createElement("button");
  button.append(`Line ${line}: ${message}`);
  for (const more of [label, help]) {
    if (!more) continue;
    const small = document.createElement("small");
    small.textContent = more;
    button.append(small);
  }
  button.addEventListener("click", () => select(span));
  item.append(button);
  return item;
}

function select([from, to]) {
  area.focus();
  area.setSelectionRange(from, to);
  const line = area.value.slice(0, from).split("\n").length;
  area.scrollTop = Math.max(0, (line - 4) * parseFloat(getComputedStyle(area).lineHeight));
}
