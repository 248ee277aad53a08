// A replay under the control of scripts: `llsrbm.replay` in the page itself, and messages to and from
// the page that has it in a frame (docs/embedding.md).
(() => {
  const { player } = window.llsrbm;
  const SCHEMES = /^(https?|file|blob):/;
  const GENERATOR = '<meta name="generator" content="llsrbm', HEAD = 4096; // bytes that have it
  let told = null; // what was told last

  const acts = {
    play: player.play,
    pause: player.pause,
    seek(time) {
      if (!Number.isFinite(time)) throw new Error(`seek: expected seconds, got ${time}`);
      player.seek(time);
    },
    // Another replay in place of this one: its address, or its bytes. An address is not tried
    // before, as a replay asks nothing of a network.
    load(source) {
      if (typeof source !== "string") return void loadBytes(new Blob([source], { type: "text/html" }));
      const url = new URL(source, document.baseURI).href;
      if (!SCHEMES.test(url))
        throw new Error(`load: expected an address of http, https, file or blob, got ${url.slice(0, 40)}`);
      location.replace(url);
    },
  };

  async function loadBytes(file) {
    const head = await file.slice(0, HEAD).text();
    if (head.includes(GENERATOR)) location.replace(URL.createObjectURL(file));
    else tell("refused", { why: "load: expected an address, or the bytes of a replay" });
  }

  function tell(kind, more) {
    const what = { time: player.time, playing: player.playing, end: player.clip?.end ?? 0, ...more };
    dispatchEvent(new CustomEvent(`llsrbm-${kind}`, { detail: what }));
    if (parent !== window) parent.postMessage({ llsrbm: kind, ...what }, "*");
  }

  window.addEventListener("message", ({ data, source, origin }) => {
    const act = data?.llsrbm;
    if (source !== parent || parent === window || !Object.hasOwn(acts, act)) return;
    try {
      // Bytes become a page of this origin: a page of another one sets the frame's address itself.
      if (act === "load" && typeof data.value !== "string" && origin !== window.origin)
        throw new Error("load: expected an address, for this page's origin is another one");
      acts[act](data.value);
    } catch (error) {
      tell("refused", { why: error.message });
    }
  });

  player.listen(() => {
    const now = `${player.time} ${player.playing}`;
    if (now !== told) tell("frame");
    told = now;
  });

  window.llsrbm.replay = {
    ...acts,
    ready: () => tell("ready"), // the motion is there
    get time() { return player.time; },
    get end() { return player.clip?.end ?? 0; },
    get playing() { return player.playing; },
  };
})();
