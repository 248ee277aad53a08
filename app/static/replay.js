// A page that plays a motion from disk (app/replay.py): it gives the player its clip once viser has
// drawn the scene, and shows title, outcome and switches of the layers.
(() => {
  const { element, swatch, player, addToPage } = window.llsrbm;
  const WAIT = 30; // ms between looks whether viser has made its nodes

  const STYLE = `
    #llsrbm-replay { position: fixed; z-index: 4; top: 12px; left: 18px; right: 220px;
      margin-top: 44px; pointer-events: none; color: var(--mantine-color-text);
      font: 13px/1.4 system-ui, sans-serif; }
    #llsrbm-replay h1 { margin: 0; font-size: 19px; font-weight: 600; }
    #llsrbm-replay p { margin: 2px 0 0; max-width: 60em; }
    #llsrbm-replay p.bad { color: #b3201f; }
    #llsrbm-layers { position: fixed; z-index: 4; top: 12px; right: 14px; margin: 0; padding: 6px 12px;
      border: 0; border-radius: 8px; font: 13px system-ui, sans-serif;
      color: var(--mantine-color-text); background: var(--mantine-color-body); }
    #llsrbm-layers label { display: flex; gap: 6px; align-items: center; padding: 2px 0; }
    #llsrbm-layers input { margin: 0; }
    #llsrbm-layers i { width: 10px; height: 10px; border-radius: 3px; }
    [class*="Notifications-root"] { top: 120px !important; }
    div:has(> [aria-label$="scene tree"]) { display: none; }`;

  const facts = JSON.parse(document.getElementById("facts").textContent);
  const outcome = element("p", { role: "status" }, facts.outcome);
  outcome.classList.toggle("bad", !facts.good);
  const header = element("header", { id: "llsrbm-replay" },
    element("h1", {}, facts.title), outcome);
  const switches = element("fieldset", { id: "llsrbm-layers", "aria-label": "Shown" },
    ...facts.layers.map(({ title, hint, colours, node }) => {
      const box = element("input", { type: "checkbox", checked: "",
        onchange: () => show(node, box.checked) });
      return element("label", { title: hint }, box, title, ...colours.map(swatch));
    }));
  addToPage(STYLE, header, switches);

  function show(name, visible) {
    const viewer = window.__viserMutable;
    viewer.messageQueue.push({ type: "SetSceneNodeVisibilityMessage", name, visible });
    viewer.requestRender();
  }

  // Nodes without a size at first are there as well: viser makes all of them before it draws.
  const nodes = facts.clip.channels.flatMap(({ tracks }) => tracks.flatMap((track) => track.nodes));
  const wait = setInterval(() => {
    const viewer = window.__viserMutable;
    if (window.llsrbm.page.missing.length || !viewer.cameraControl) return;
    if (!nodes.every((name) => viewer.nodeRefFromName[name])) return;
    clearInterval(wait);
    player.load(facts.clip, facts.numbers, 0);
    window.llsrbm.transport.show(facts.timeline);
    window.llsrbm.charts.show(facts.charts);
    player.setSpeed(0.5);
    player.play();
    window.llsrbm.replay.ready();
  }, WAIT);
})();
