// The page's side of the link to its session (app/link.py): it answers when the
// session calls, keeps what shall outlive the connection, and makes links that open a design.
// First of all, it checks every field of viser's that the scripts lean on.
(() => {
  const CHECKED_EVERY = 100, READY_WITHIN = 5000; // ms; viser fills some fields when it has drawn first
  const TAB = "llsrbm.tab", DESIGN = "llsrbm.design", PREFERENCES = "llsrbm.preferences"; // names in the browser's storage
  const SHARED = "#design=";

  const llsrbm = window.llsrbm;
  const hidden = {}; // storage for a browser that forbids it
  let field = null, count = 0;

  const needs = []; // functions that return the names of missing fields
  llsrbm.require = (check) => needs.push(check);
  const missing = () => [...new Set(needs.flatMap((check) => check()))];

  // Those of the paths, such as "camera.fov", at which an object has nothing.
  llsrbm.lacking = (object, paths) => paths.filter((path) =>
    path.split(".").reduce((owner, name) => owner?.[name], object ?? {}) == null);
  llsrbm.require(() => llsrbm.lacking(window, ["__viserMutable.sendMessage"]));

  function stored(kind, key) {
    try {
      return window[kind].getItem(key);
    } catch {
      return hidden[kind + key] ?? null;
    }
  }

  // This tab's own, else what another tab kept last.
  const storedHere = (key) => stored("sessionStorage", key) ?? stored("localStorage", key);

  function store(kind, key, value) {
    try {
      if (value === null) window[kind].removeItem(key);
      else window[kind].setItem(key, value);
    } catch {
      hidden[kind + key] = value;
    }
  }

  // For this tab, and for tabs that are opened later.
  function storeHere(key, value) {
    store("sessionStorage", key, value);
    store("localStorage", key, value);
  }

  const system = matchMedia("(prefers-color-scheme: dark)");
  system.addEventListener("change", () => send({ kind: "scheme", dark: system.matches }));

  // The server knows this tab again by its name: after a reload, and after the tab crashed. A copy of
  // the tab gets the name along with the storage, hears from the other that it is in use, and takes
  // a new one before it greets the server.
  const newName = () => [...crypto.getRandomValues(new Uint8Array(16))]
    .map((byte) => byte.toString(16).padStart(2, "0")).join("");
  let tab = stored("sessionStorage", TAB) ?? newName(), greeted = false;
  store("sessionStorage", TAB, tab);
  const tabs = new BroadcastChannel(TAB);
  tabs.onmessage = ({ data: { asks, used } }) => {
    if (asks === tab) tabs.postMessage({ used: tab });
    if (used !== tab || greeted) return;
    tab = newName();
    store("sessionStorage", TAB, tab);
  };
  tabs.postMessage({ asks: tab });

  // The design in the address: opened once, so that a reload finds what came of it.
  function designIn(fragment) {
    if (!fragment.startsWith(SHARED)) return null;
    const code = fragment.slice(SHARED.length).replace(/-/g, "+").replace(/_/g, "/");
    try {
      const bytes = Uint8Array.from(atob(code), (character) => character.charCodeAt(0));
      return new TextDecoder().decode(bytes);
    } catch {
      return "a link that was cut"; // the server's reader refuses it, and the refusal is shown
    }
  }
  let shared = designIn(window.llsrbmFragment ?? ""); // address.js took it out of the address
  window.addEventListener("hashchange", () => {
    const design = designIn(location.hash);
    if (design === null) return;
    history.replaceState(null, "", location.pathname + location.search);
    shared = design;
    greet();
  });

  function link(design) {
    const bytes = new TextEncoder().encode(design);
    const code = btoa(String.fromCharCode(...bytes)).replace(/\+/g, "-").replace(/\//g, "_")
      .replace(/=+$/, "");
    return location.origin + location.pathname + SHARED + code;
  }

  function send(event) {
    if (!field) return;
    // A number makes every message a change, which is what viser passes on.
    const value = JSON.stringify({ ...event, count: (count += 1) });
    window.__viserMutable?.sendMessage({
      type: "GuiUpdateMessage", uuid: field, updates: { value },
    });
  }

  function greet() {
    greeted = true;
    const { time = 0, playing = false } = llsrbm.player ?? {};
    send({
      kind: "ready", software: llsrbm.software, missing: missing(), tab, shared, time, playing,
      kept: storedHere(DESIGN), preferences: storedHere(PREFERENCES), dark: system.matches,
      height: innerHeight,
    });
    shared = null;
  }

  // viser shows a cloud with a tick while it is connected. Words say what its dots mean.
  const LOST_AFTER = 1200; // ms
  const lost = llsrbm.element("div", { id: "llsrbm-lost", role: "alert" });
  let wasConnected = false, lostSince = 0;
  llsrbm.addToPage(`
    #llsrbm-lost { position: fixed; left: 50%; top: 10px; transform: translateX(-50%); z-index: 600;
      max-width: 90vw; padding: 6px 14px; border-radius: 6px; font: 14px/1.4 system-ui, sans-serif;
      color: #3a2600; background: #ffd98a; border: 1px solid #d08a1d; }
    #llsrbm-lost:empty { display: none; }`, lost);
  setInterval(() => {
    const connected = Boolean(document.querySelector(".tabler-icon-cloud-check"));
    wasConnected ||= connected;
    if (connected) lostSince = 0;
    else if (wasConnected) lostSince ||= performance.now();
    const words = lostSince && performance.now() - lostSince > LOST_AFTER
      ? "The server is not reached. The page tries again by itself and finds your design then; "
        + "the motion plays on meanwhile." : "";
    if (lost.textContent !== words) lost.textContent = words;
  }, 500);

  llsrbm.page = {
    connect(uuid) {
      field = uuid;
      llsrbm.atlas?.forget(); // another session has sent none
      const since = performance.now();
      const check = () => {
        if (field !== uuid) return;
        if (missing().length === 0 || performance.now() - since > READY_WITHIN) greet();
        else setTimeout(check, CHECKED_EVERY);
      };
      check();
    },
    keep: (design) => storeHere(DESIGN, design),
    prefer: (preferences) => storeHere(PREFERENCES, preferences),
    async share(design) {
      const address = link(design);
      let copied = true;
      try {
        await navigator.clipboard.writeText(address);
      } catch {
        copied = false; // not allowed, or not over http: it can be copied by hand
      }
      llsrbm.dialog.open(
        "Share this design",
        copied ? "The link is copied. It opens this whole design on this server."
          : "Copy this link. It opens this whole design on this server.",
        address,
      );
    },
    send,
    get missing() { return missing(); },
  };
})();
