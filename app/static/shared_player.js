// Puts together a page of a folder of replays (app/shared_pages.py): its motion, the meshes of its
// robot, and the scripts that all pages have, which then do as in a page that is one file.
(async () => {
  const BLOCK = 1 << 17; // bytes of a block of zstd, at most
  const motion = window.llsrbmMotion;

  const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));

  async function unpacked(text) {
    const stream = new Blob([bytes(text)]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  function joined(parts) {
    const whole = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
    let at = 0;
    for (const part of parts) {
      whole.set(part, at);
      at += part.length;
    }
    return whole;
  }

  const little = (value, count) =>
    Uint8Array.from({ length: count }, (_, k) => Math.floor(value / 256 ** k) % 256);

  // A frame of zstd whose blocks are as they are: viser reads nothing else.
  function framed(content) {
    const parts = [Uint8Array.of(0x28, 0xb5, 0x2f, 0xfd, 0xa0), little(content.length, 4)];
    for (let at = 0; at < content.length; at += BLOCK) {
      const block = content.subarray(at, at + BLOCK);
      const last = at + BLOCK >= content.length;
      parts.push(little(block.length * 8 + (last ? 1 : 0), 3), block);
    }
    return joined([little(content.length, 8), ...parts]);
  }

  function base64(content) {
    const PART = 0x8000; // arguments of a call
    let text = "";
    for (let at = 0; at < content.length; at += PART)
      text += String.fromCharCode(...content.subarray(at, at + PART));
    return btoa(text);
  }

  function put(text, attributes) {
    const script = document.createElement("script");
    for (const [name, value] of Object.entries(attributes)) script.setAttribute(name, value);
    script.textContent = text;
    document.head.append(script);
  }

  const [facts, own, meshes] = await Promise.all(
    [motion.facts, motion.own, window.llsrbmMeshes].map(unpacked));
  const scene = [];
  let at = 0;
  for (const [length, start, end] of motion.pieces) {
    scene.push(own.subarray(at, at + length), meshes.subarray(start, end));
    at += length;
  }
  put(new TextDecoder().decode(facts), { type: "application/json", id: "facts" });
  window.__VISER_EMBED_DATA__ = base64(framed(joined(scene)));
  window.__VISER_EMBED_CONFIG__ = { darkMode: false };
  for (const { text, attributes } of window.llsrbmScripts) put(text, attributes);
  // The scripts wait for a page that has been there for long: the browser's own event was before.
  document.dispatchEvent(new Event("DOMContentLoaded"));
})();
