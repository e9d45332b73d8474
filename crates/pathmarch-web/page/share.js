// Scenes in the fragment of an address: deflated, in the alphabet of base64url. No server sees a fragment.

async function through(bytes, stream) {
  return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());
}

/** Address of this page with a scene in it. */
export async function linkTo(scene) {
  const packed = await through(new TextEncoder().encode(JSON.stringify(scene)), new CompressionStream("deflate-raw"));
  let binary = "";
  for (const byte of packed) binary += String.fromCharCode(byte);
  const code = btoa(binary).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
  return `${location.origin}${location.pathname}#scene=${code}`;
}

/** Scene of a fragment; null if there is none, or it is damaged. */
export async function sceneOf(fragment) {
  const code = /^#scene=([\w-]+)$/.exec(fragment)?.[1];
  if (!code) return null;
  try {
    const binary = atob(code.replaceAll("-", "+").replaceAll("_", "/"));
    const packed = Uint8Array.from(binary, (character) => character.charCodeAt(0));
    const scene = JSON.parse(new TextDecoder().decode(await through(packed, new DecompressionStream("deflate-raw"))));
    return typeof scene.text === "string" ? scene : null;
  } catch {
    return null;
  }
}
