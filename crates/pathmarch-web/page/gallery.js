// The example scenes, and the files that they name.

const dialog = document.querySelector("#gallery");
const mounted = new Set();
let listing;

/** Opens scenes of the gallery by `open(name, text)`; `mount` gives files to everyone who reads scenes. */
export async function fill(open) {
  const scenes = await list();
  document.querySelector("#scenes").replaceChildren(...scenes.map((scene) => card(scene, open)));
}

export function show() {
  dialog.showModal();
}

async function list() {
  listing ??= await (await fetch("scenes/gallery.json")).json();
  return listing.scenes;
}

function card({ name, doc, file, picture }, open) {
  const button = document.createElement("button");
  const image = Object.assign(new Image(), { src: `scenes/${picture}`, alt: "", loading: "lazy" });
  const caption = document.createElement("span");
  caption.append(Object.assign(document.createElement("b"), { textContent: name }), ` ${doc}`);
  button.append(image, caption);
  button.addEventListener("click", () => {
    dialog.close();
    open(file);
  });
  return button;
}

/** Text of an example by its name or file; null if there is none. */
export async function load(nameOrFile) {
  const scene = (await list()).find(({ name, file }) => nameOrFile === name || nameOrFile === file);
  if (!scene) return null;
  return { name: scene.file, text: await (await fetch(`scenes/${scene.file}`)).text() };
}

/** Files of the gallery that a text names and that no text named before: pairs of path and bytes. */
export async function filesOf(text) {
  await list();
  const found = [];
  for (const file of listing.files) {
    if (mounted.has(file) || !text.includes(file)) continue;
    mounted.add(file);
    found.push(file);
  }
  const load = async (file) => [file, new Uint8Array(await (await fetch(`scenes/${file}`)).arrayBuffer())];
  return Promise.all(found.map(load));
}
