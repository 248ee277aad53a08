// Ask the picture: what a joint, a foot or the trunk under the pointer does at this instant, also when
// it came there under a pointer that rests. While it plays, the part stays that was pointed at. A click
// keeps the answer, from which rows go into the plots. With Ctrl held the trunk is pulled, and
// without it the ball at the tip of a push that is drawn: a push.
(() => {
  const { page, player, element, write, addToPage } = window.llsrbm;
  const NEAR = 14, FOOT_BEFORE = 5; // pixels; a foot is preferred to the link that it ends
  const TRUNK = "trunk", TRUNK_NEAR = 45; // pixels
  const PULLED_WITHIN = 60, TIP_WITHIN = 22; // pixels of any part, and of a push's tip
  const TIP = "/push/tip"; // app/picture/push_handle.py
  const CLICK = 4; // pixels that a hand trembles
  const ASKED_AFTER = 90, ASKED_AGAIN = 1000, PULL_EVERY = 60; // ms
  const FARTHEST = 3; // m that a hand pulls

  const STYLE = `
    #llsrbm-part { position: fixed; z-index: 6; display: none; padding: 6px 9px 7px;
      border-radius: 6px; pointer-events: none; font: 12px system-ui, sans-serif;
      color: var(--mantine-color-text); background: var(--mantine-color-body);
      border: 1px solid var(--mantine-color-default-border);
      box-shadow: 0 2px 8px rgba(0, 0, 0, 0.2); }
    #llsrbm-part.kept { pointer-events: auto; }
    #llsrbm-part header { display: flex; gap: 10px; justify-content: space-between;
      font-weight: 600; }
    #llsrbm-part td { padding: 0 10px 0 0; white-space: nowrap; text-align: right;
      font-variant-numeric: tabular-nums; }
    #llsrbm-part td:first-child { text-align: left; }
    #llsrbm-part td.value { min-width: 4.2em;
      color: color-mix(in srgb, var(--llsrbm-line) 60%, var(--mantine-color-text)); }
    #llsrbm-part button { padding: 0 5px; min-width: 24px; min-height: 24px; cursor: pointer;
      color: inherit; background: none; border: 0; border-radius: 4px; }
    #llsrbm-part button:hover { background: var(--mantine-color-default-hover); }
    #llsrbm-part:not(.kept) button { display: none; }
    #llsrbm-part footer { color: var(--mantine-color-dimmed); font-size: 12px; }
    #llsrbm-part.kept footer { display: none; }
    #llsrbm-part-dot { position: fixed; z-index: 5; display: none; width: 12px; height: 12px;
      margin: -6px 0 0 -6px; border-radius: 50%; pointer-events: none; box-sizing: border-box;
      border: 2px solid #fff; outline: 1.5px solid #14181c; }`;

  const box = element("div", { id: "llsrbm-part", role: "region", "aria-label": "Part" });
  const dot = element("div", { id: "llsrbm-part-dot" });

  let known = new Map(); // what parts do, of the clip that is played
  let part = null; // that is pointed at, or kept
  let kept = false, asking = null, drawn = null, at = [0, 0];
  let quiet = false; // clicks mean something else
  let rests = false; // whether the pointer is in the picture, with no button down
  let pressed = null; // where a button went down
  let pull = null, pulledAt = 0;

  const viewer = () => window.__viserMutable;

  // ---- where parts are, in pixels

  function projected({ node, ends }) {
    const { camera, nodeRefFromName, canvas } = viewer();
    const object = nodeRefFromName[node];
    if (!object) return null;
    const view = canvas.getBoundingClientRect();
    object.updateWorldMatrix(true, false);
    return ends.map((end) => {
      const place = object.localToWorld(camera.position.clone().set(...end)).project(camera);
      return [view.left + ((1 + place.x) / 2) * view.width,
        view.top + ((1 - place.y) / 2) * view.height];
    });
  }

  // Pixels from a point to the line between two, and the place there.
  function distance([x, y], [[ax, ay], [bx, by]]) {
    const [dx, dy] = [bx - ax, by - ay], length = dx * dx + dy * dy;
    const share = length && Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / length));
    return Math.hypot(x - ax - share * dx, y - ay - share * dy);
  }

  function pick(point, within = null) {
    if (!player.clip?.parts.length || !viewer()?.camera) return null;
    viewer().camera.updateMatrixWorld();
    let best = null, least = Infinity;
    for (const each of player.clip.parts) {
      const ends = projected(each);
      if (!ends) continue;
      const trunk = each.name === TRUNK, foot = each.ends[0].join() === each.ends[1].join();
      const away = distance(point, ends);
      if (away > (within ?? (trunk ? TRUNK_NEAR : NEAR))) continue;
      const rank = away + (trunk ? NEAR : 0) - (foot ? FOOT_BEFORE : 0);
      if (rank < least) [best, least] = [each, rank];
    }
    return best;
  }

  // ---- what they do

  function point(found, where) {
    at = where;
    if (found?.name !== part?.name) {
      part = found;
      clearTimeout(asking);
      if (part && !known.has(part.name)) asking = setTimeout(ask, ASKED_AFTER);
    }
    refresh();
  }

  function ask() {
    clearTimeout(asking);
    if (!part || known.has(part.name)) return;
    page.send({ kind: "part", part: part.name });
    // There is no answer as long as the server has no motion to read it from.
    asking = setTimeout(ask, ASKED_AGAIN);
  }

  // The motion or the camera has moved.
  function look() {
    if (rests && !kept && !pull && !player.playing) point(pick(at), at);
    else if (part) refresh();
  }

  const written = (value) => {
    if (value === undefined || value === null) return "–";
    const digits = Math.abs(value) < 10 ? 2 : Math.abs(value) < 100 ? 1 : 0;
    const text = value.toFixed(digits);
    return Number(text) === 0 ? (0).toFixed(digits) : text.replace("-", "−");
  };

  function draw(reading) {
    drawn = reading;
    const rows = reading.rows.map(({ title, number, unit, lines }) => element("tr", {},
      element("td", {}, title),
      ...lines.map(({ title: motion, colour }) => element("td",
        { class: "value", title: motion, style: `--llsrbm-line: ${colour}` })),
      element("td", {}, unit),
      element("td", {}, element("button", { type: "button", title: "Add to the plots",
        "aria-label": `Add ${title} of ${reading.part} to the plots`,
        onclick: () => page.send({ kind: "plot", part: reading.part, row: number }) }, "+"))));
    box.replaceChildren(
      element("header", {}, reading.part, element("button",
        { type: "button", "aria-label": "Close the part", onclick: release }, "×")),
      element("table", {}, element("tbody", {}, ...rows)),
      element("footer", {}, "click to keep, Ctrl-drag to push"));
  }

  function refresh() {
    const reading = part && known.get(part.name);
    const ends = reading?.rows.length && !pull ? projected(part) : null;
    box.style.display = dot.style.display = ends ? "block" : "none";
    if (!ends) return;
    if (drawn !== reading) draw(reading);
    box.classList.toggle("kept", kept);
    const cells = box.querySelectorAll("td.value");
    const values = reading.rows.flatMap(({ lines }) => lines.map((line) => line.values));
    values.forEach((series, i) => {
      const index = Math.round(player.time / reading.step);
      write(cells[i], written(series[Math.min(index, series.length - 1)]));
    });
    const [x, y] = part.name === TRUNK ? [(ends[0][0] + ends[1][0]) / 2,
      (ends[0][1] + ends[1][1]) / 2] : part.name.endsWith(" foot") ? ends[1] : ends[0];
    Object.assign(dot.style, { left: `${x}px`, top: `${y}px` });
    const view = viewer().canvas.getBoundingClientRect();
    Object.assign(box.style, {
      left: `${Math.min(at[0] + 16, view.right - box.offsetWidth - 4)}px`,
      top: `${Math.max(view.top, Math.min(at[1] + 16, view.bottom - box.offsetHeight - 4))}px`,
    });
  }

  function release() {
    kept = false;
    point(null, at);
  }

  // ---- a pull

  // Where the line of sight through a pixel meets the level plane through the trunk, m.
  function meets([x, y], height) {
    const { camera, canvas, nodeRefFromName } = viewer();
    const view = canvas.getBoundingClientRect(), root = nodeRefFromName[""];
    const far = camera.position.clone().set(
      (2 * (x - view.left)) / view.width - 1, 1 - (2 * (y - view.top)) / view.height, 0.5);
    const there = root.worldToLocal(far.unproject(camera));
    const from = root.worldToLocal(camera.getWorldPosition(camera.position.clone()));
    const share = (height - from.z) / (there.z - from.z);
    if (!(share > 0)) return null;
    return [from.x + share * (there.x - from.x), from.y + share * (there.y - from.y)];
  }

  function trunk() {
    const { nodeRefFromName, camera } = viewer();
    const found = player.clip?.parts.find(({ name }) => name === TRUNK);
    const object = found && nodeRefFromName[found.node];
    if (!object) return null;
    const [a, b] = found.ends.map((end) => camera.position.clone().set(...end));
    return nodeRefFromName[""].worldToLocal(object.localToWorld(a.lerp(b, 0.5)));
  }

  // The tip of a push that can be dragged, in the scene's frame; null: it is not there, or elsewhere.
  function tip(where) {
    const node = viewer().nodeRefFromName[TIP];
    if (!node?.visible || !player.clip) return null;
    viewer().camera.updateMatrixWorld();
    const ends = projected({ node: TIP, ends: [[0, 0, 0], [0, 0, 0]] });
    if (distance(where, ends) > TIP_WITHIN) return null;
    return viewer().nodeRefFromName[""].worldToLocal(node.getWorldPosition(node.position.clone()));
  }

  // Whether a push begins here: by as much as the hand moves it differs from the one before.
  function takeHold(event, where) {
    if (event.button !== 0) return false;
    const held = tip(where), middle = trunk();
    if (!middle || !(held || (event.ctrlKey && pick(where, PULLED_WITHIN)))) return false;
    const z = (held ?? middle).z, from = meets(where, z);
    if (!from) return false;
    const before = held ? [held.x - middle.x, held.y - middle.y] : [0, 0];
    pull = { z, from, before, hand: from };
    return true;
  }

  function sendPull(where, ended) {
    const now = performance.now();
    if (!ended && now - pulledAt < PULL_EVERY) return;
    pulledAt = now;
    pull.hand = meets(where, pull.z) ?? pull.hand;
    const by = [0, 1].map((axis) => pull.before[axis] + pull.hand[axis] - pull.from[axis]);
    const shorter = Math.min(1, FARTHEST / (Math.hypot(...by) || 1));
    page.send({ kind: "push", time: player.time, x: shorter * by[0], y: shorter * by[1], ended });
  }

  // ---- the pointer; before viser's camera hears of it

  const inPicture = ({ target }) => target === viewer()?.canvas;

  function down(event) {
    rests = false;
    if (!inPicture(event)) return;
    const where = [event.clientX, event.clientY];
    pressed = where;
    if (!takeHold(event, where)) return;
    event.target.setPointerCapture(event.pointerId);
    event.preventDefault();
    event.stopImmediatePropagation();
    player.pause();
    refresh();
  }

  function move(event) {
    const where = [event.clientX, event.clientY];
    if (pull) {
      event.stopImmediatePropagation();
      sendPull(where, false);
    } else if (!event.buttons && event.pointerType !== "touch") {
      rests = inPicture(event);
      if (!kept) point(rests ? pick(where) : null, where);
    }
  }

  function up(event) {
    const where = [event.clientX, event.clientY];
    if (pull) {
      event.stopImmediatePropagation();
      sendPull(where, true);
      pull = null;
    } else if (pressed && !quiet && inPicture(event)
      && Math.hypot(where[0] - pressed[0], where[1] - pressed[1]) < CLICK) {
      const found = pick(where);
      kept = found !== null;
      point(found, where);
    }
    pressed = null;
  }

  window.addEventListener("pointerdown", down, { capture: true });
  window.addEventListener("pointermove", move, { capture: true });
  window.addEventListener("pointerup", up, { capture: true });
  window.addEventListener("keydown", (event) => event.key === "Escape" && kept && release());
  addToPage(STYLE, box, dot);
  player.listen(look);

  window.llsrbm.parts = {
    look,
    show(reading) {
      known.set(reading.part, reading);
      refresh();
    },
    // Another motion is played.
    forget() {
      known = new Map();
      ask();
    },
    // Whether clicks keep no answer, as they are landings of a route.
    setQuiet(on) {
      quiet = on;
      if (on) release();
    },
    get pulls() { return pull !== null; },
  };
})();
