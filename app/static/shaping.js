// Handles in the timeline that change the plan (app/tab/shaping.py): the phases' edges, dragged along
// the time, and the apex, dragged up and down. The server plans as it does while a slider moves.
(() => {
  const { page, player, timeline, element, addToPage } = window.llsrbm;
  const SNAP = 6; // pixels from an event at which an edge goes there
  const PER_PIXEL = 0.002; // m of height
  const STEPS = { edge: 0.01, apex: 0.005 }, FAR = 5; // s and m an arrow key; as many with Shift
  const EVERY = 40; // ms between messages of a drag
  const RESTS = 1500; // ms after which keys that go on begin another step to be undone

  const STYLE = `
    #llsrbm-transport .shape { position: absolute; width: 12px; margin-left: -6px; z-index: 2;
      touch-action: none; }
    #llsrbm-transport .shape.edge { top: ${timeline.top - 3}px; height: 22px; cursor: col-resize; }
    #llsrbm-transport .shape.edge::before { content: ""; position: absolute; inset: 2px 4px;
      border-radius: 2px; background: var(--mantine-color-text);
      outline: 1px solid var(--mantine-color-body); }
    #llsrbm-transport .shape.apex { top: ${timeline.top - 7}px; height: 14px; cursor: ns-resize; }
    #llsrbm-transport .shape.apex::before { content: ""; position: absolute; inset: 2px 1px;
      transform: rotate(45deg); background: var(--mantine-color-text);
      outline: 1px solid var(--mantine-color-body); }
    #llsrbm-transport .shape:is(:hover, :focus-visible, .held)::before {
      background: var(--mantine-primary-color-filled); }
    #llsrbm-transport .shape output { display: none; position: absolute; bottom: 100%; left: 50%;
      transform: translateX(-50%); padding: 1px 6px; border-radius: 4px; font-size: 12px;
      line-height: 16px; white-space: nowrap; pointer-events: none;
      color: var(--mantine-color-text); background: var(--mantine-color-body);
      border: 1px solid var(--mantine-color-default-border); }
    #llsrbm-transport .shape.held output { display: block; }`;

  let shown = null; // app/tab/shaping.py, `Handles`
  let handles = []; // { made, kind, index }
  let held = null; // what is dragged: { handle, from, value, starts, y }
  let last = null, lastAt = -Infinity; // the handle that was moved last, and when, ms
  let waits = null; // the message that is sent soon

  const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
  const partOf = ({ kind, index }) => (kind === "apex" ? shown?.apex : shown?.edges[index]);
  const valueOf = (handle) => (handle.kind === "apex" ? partOf(handle).height : partOf(handle).time);
  const words = ({ kind }, value) =>
    (kind === "apex" ? `${value.toFixed(3)} m above the ground` : `${value.toFixed(3)} s`);

  // ---- what is said to the server

  function message(handle, value, starts) {
    if (handle.kind === "apex") return { kind: "apex", height: value };
    const edges = [...starts];
    edges[handle.index + 1] = value;
    const durations = edges.slice(1, partOf(handle).phases + 1).map((end, i) => end - edges[i]);
    return { kind: "phases", durations };
  }

  function put(handle, value, { starts = shown.starts, begins, soon = false }) {
    const next = { ...message(handle, value, starts), begins };
    if (begins || !soon) return flush(next);
    waits ??= { timer: setTimeout(() => flush(), EVERY) };
    waits.message = next;
  }

  function flush(next = waits?.message) {
    clearTimeout(waits?.timer);
    waits = null;
    if (next) page.send(next);
  }

  // ---- what is drawn

  function show(next) {
    const same = next && shown && next.edges.length === shown.edges.length
      && Boolean(next.apex) === Boolean(shown.apex);
    shown = next;
    if (!same) {
      held = null;
      for (const { made } of handles) made.remove();
      handles = next ? [...next.edges.map((_, index) => handle("edge", index)),
        ...(next.apex ? [handle("apex", 0)] : [])] : [];
      timeline.track.append(...handles.map(({ made }) => made));
    }
    place();
  }

  function place() {
    for (const each of handles) {
      const part = partOf(each), value = held?.handle === each ? held.value : valueOf(each);
      const time = each.kind === "edge" ? value : part.time;
      each.made.style.left = timeline.percent(time);
      each.made.style.display = timeline.visible(time) ? "" : "none";
      for (const [name, number] of [["min", part.low], ["max", part.high], ["now", value]])
        each.made.setAttribute(`aria-value${name}`, number.toFixed(3));
      each.made.setAttribute("aria-valuetext", words(each, value));
      each.made.firstChild.textContent = `${part.name}: ${words(each, value)}`;
    }
  }

  // ---- handles

  function handle(kind, index) {
    const does = kind === "apex"
      ? "Drag up or down, or arrow keys: the plan flies so high, and as long as that takes"
      : "Drag, or arrow keys: the phases up to the one that begins here last as long in the plan";
    const tip = `${does}. A double-click or Delete lets it go.`;
    const made = element("div", { class: `shape ${kind}`, role: "slider", tabindex: 0,
      "aria-orientation": kind === "apex" ? "vertical" : "horizontal",
      "aria-label": partOf({ kind, index }).name,
      "data-tip": tip, "aria-description": tip }, element("output"));
    const self = { made, kind, index };
    made.addEventListener("pointerdown", (event) => {
      event.stopPropagation();
      made.setPointerCapture(event.pointerId);
      made.classList.add("held");
      const value = valueOf(self);
      held = { handle: self, from: value, value, starts: shown.starts, y: event.clientY, moved: false };
    });
    made.addEventListener("pointermove", (event) => {
      if (held?.handle === self) drag(event);
    });
    for (const end of ["pointerup", "pointercancel"]) made.addEventListener(end, release);
    made.addEventListener("dblclick", (event) => {
      event.stopPropagation();
      letGo(self);
    });
    made.addEventListener("keydown", (event) => press(self, event));
    return self;
  }

  function drag({ clientX, clientY }) {
    const { handle: self, from, y } = held, { low, high } = partOf(self);
    const wanted = self.kind === "apex" ? from + (y - clientY) * PER_PIXEL
      : snapped(timeline.timeBelow(clientX), from);
    const value = clamp(wanted, low, high);
    if (value === held.value) return;
    held.value = value;
    put(self, value, { starts: held.starts, begins: !held.moved, soon: true });
    held.moved = true;
    last = null; // keys after it begin another step
    place();
  }

  // To an event that is near, or to where the motion stands; its own event goes along with the edge.
  function snapped(time, from) {
    const near = SNAP * timeline.perPixel;
    const found = [...timeline.marks, player.time, from]
      .filter((each) => each === from || Math.abs(each - from) > near)
      .sort((a, b) => Math.abs(a - time) - Math.abs(b - time))[0];
    return found !== undefined && Math.abs(found - time) <= near ? found : time;
  }

  // A press that moves nothing goes to the instant, as everywhere in the timeline.
  function release({ type, clientX }) {
    if (type === "pointerup" && held && !held.moved) {
      player.goTo(clamp(timeline.timeBelow(clientX), 0, player.clip.end));
    }
    held?.handle.made.classList.remove("held");
    held = null;
    flush();
    place();
  }

  function letGo({ kind }) {
    last = null;
    page.send(kind === "apex" ? { kind: "apex", height: null, begins: true }
      : { kind: "phases", durations: [], begins: true });
  }

  function press(self, event) {
    const { key, shiftKey } = event, { low, high } = partOf(self);
    const by = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[key];
    if (key === "Delete" || key === "Backspace") letGo(self);
    else if (by || key === "Home" || key === "End") {
      const step = STEPS[self.kind] * (shiftKey ? FAR : 1) * (by ?? 0);
      const now = performance.now(), begins = last !== self || now - lastAt > RESTS;
      const value = clamp(by ? chosen(self, begins) + step : key === "Home" ? low : high, low, high);
      [last, lastAt, self.chosen] = [self, now, value];
      put(self, value, { begins });
    } else return;
    event.preventDefault();
    event.stopPropagation();
  }

  // Plans come later than the keys: the next step goes on from where the last one led.
  const chosen = (self, begins) => (begins ? valueOf(self) : self.chosen);

  addToPage(STYLE);
  timeline.onDrawn(place);

  window.llsrbm.shaping = { show };
})();
