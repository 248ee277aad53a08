// The strips under the picture: phases of plan and simulation with their names at the left, marks,
// a scale of time, and the range that is played again and again. Drag to scrub, turn the wheel to
// zoom, drag the two handles (or with Shift) for the range; a double-click shows all again.
(() => {
  const { player, element, swatch } = window.llsrbm;
  const LANES = 2, LANE = 15, BESIDE = 6; // lines of labels above the strips; pixels
  const STEPS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5]; // s between the scale's numbers
  const LETTER = 7; // pixels of one, about
  const TICK = 54; // pixels at least from one to the next
  const NARROWEST = 0.05; // s in sight, or of a range
  const FRAME = 1 / 60, FAR = 6; // s that an arrow key moves a handle; as often with Shift
  const TURN = 0.0015; // zoom of a wheel, a pixel

  const STYLE = `
    #llsrbm-transport .timeline { display: grid; grid-template-columns: max-content 1fr;
      column-gap: 8px; margin-top: 2px; }
    #llsrbm-transport .names, #llsrbm-transport .track { padding-top: ${LANES * LANE + 1}px; }
    #llsrbm-transport .names { font-size: 12px; line-height: 16px; }
    #llsrbm-transport .names > div { margin-bottom: 2px; display: flex; align-items: center;
      justify-content: flex-end; gap: 5px; min-height: 16px; }
    #llsrbm-transport .names i { width: 8px; height: 8px; border-radius: 2px; }
    #llsrbm-transport .track { position: relative; cursor: ew-resize; touch-action: none; }
    #llsrbm-transport .row { position: relative; height: 16px; margin-bottom: 2px;
      border-radius: 3px; overflow: hidden; background: var(--mantine-color-default); }
    #llsrbm-transport .row > div { position: absolute; top: 0; bottom: 0; box-sizing: border-box;
      padding: 0 3px; font-size: 12px; line-height: 16px; color: #14181c; white-space: pre;
      display: flex; overflow: hidden; background: var(--colour); }
    [data-mantine-color-scheme=dark] #llsrbm-transport .row > .phase { color: #f1f3f5;
      background: color-mix(in srgb, var(--colour) 35%, #14181c); }
    #llsrbm-transport .phase > span { overflow: hidden; text-overflow: ellipsis; min-width: 0; }
    #llsrbm-transport .phase > .feet { flex-shrink: 1000; } /* where it is narrow, the name stays */
    #llsrbm-transport .row > .low { top: 12px; }
    #llsrbm-transport :is(.bars, .tall) { height: 22px; }
    #llsrbm-transport .row.bars > .bar { top: auto; padding: 0; width: 4px; margin-left: -2px;
      background: #d6336c; }
    #llsrbm-transport .row.bars > .bar.in-time { background: #2f9e62; }
    #llsrbm-transport .row.bars > .deadline { left: 0; right: 0; top: 50%; padding: 0; bottom: auto;
      border-top: 1px dashed currentColor; color: var(--mantine-color-text); opacity: 0.6; }
    #llsrbm-transport .mark { position: absolute; bottom: 16px; width: 2px; margin-left: -1px;
      background: color-mix(in srgb, currentColor 75%, transparent); pointer-events: none; }
    #llsrbm-transport .mark span { position: absolute; top: 0; left: ${BESIDE}px; font-size: 12px;
      line-height: 14px; white-space: nowrap;
      color: color-mix(in srgb, currentColor 50%, var(--mantine-color-text)); }
    #llsrbm-transport .mark.left span { left: auto; right: ${BESIDE}px; }
    #llsrbm-transport .scale { position: relative; height: 16px; font-size: 12px; line-height: 16px;
      font-variant-numeric: tabular-nums; overflow: hidden; }
    #llsrbm-transport .scale span { position: absolute; transform: translateX(-50%); }
    #llsrbm-transport .outside { position: absolute; top: ${LANES * LANE}px; bottom: 16px;
      pointer-events: none; background: var(--mantine-color-body); opacity: 0.65; }
    #llsrbm-transport .handle { position: absolute; bottom: 0; width: 12px; height: 16px;
      margin-left: -6px; cursor: col-resize; touch-action: none; }
    #llsrbm-transport .handle::before { content: ""; position: absolute; inset: 1px 1px 2px;
      background: var(--mantine-primary-color-filled); clip-path: polygon(50% 0, 100% 100%, 0 100%); }
    #llsrbm-transport .cursor { position: absolute; top: ${LANES * LANE - 2}px; bottom: 13px; left: 0;
      width: 100%; pointer-events: none; will-change: transform; }
    #llsrbm-transport .cursor::before { content: ""; position: absolute; left: -1.5px; top: 0;
      bottom: 0; width: 3px; background: var(--mantine-color-text); border-radius: 2px; }`;

  let shown = null; // llsrbm/look/timeline.py, `Timeline`
  let view = null; // [from, to] s in sight; null: all
  let changed = () => {}; // called when what is in sight, or the range, has changed
  let drawn = () => {}; // called when the strips are drawn

  const names = element("div", { class: "names" });
  const track = element("div", { class: "track", role: "group", "aria-label": "Timeline" });
  const content = element("div");
  const cursor = element("div", { class: "cursor" });
  const outside = [0, 1].map(() => element("div", { class: "outside" }));
  const handles = ["Loop from", "Loop until"].map((label, side) => handle(label, side));

  const root = element("div", { class: "timeline" }, names, track);
  track.append(content, ...outside, cursor, ...handles);

  const end = () => Math.max(shown?.end ?? 0, 1e-6);
  const inSight = () => view ?? [0, end()];
  const range = () => (player.range ?? [0, end()]).map((time) => Math.min(time, end()));
  const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

  function share(time) {
    const [from, to] = inSight();
    return (time - from) / (to - from);
  }
  const percent = (time) => `${100 * clamp(share(time), 0, 1)}%`;
  const visible = (time) => share(time) >= -1e-9 && share(time) <= 1 + 1e-9;

  const perPixel = () => (inSight()[1] - inSight()[0]) / track.getBoundingClientRect().width;
  const timeBelow = (clientX) =>
    inSight()[0] + (clientX - track.getBoundingClientRect().left) * perPixel();
  const timeAt = (clientX) => clamp(timeBelow(clientX), 0, end());

  // ---- what is drawn

  function render() {
    if (!shown) return;
    const bars = computing(shown.bars);
    const rows = [...shown.rows.map(strip), ...bars];
    names.replaceChildren(
      ...shown.rows.map(({ name, colour }) => element("div", {}, name, swatch(colour))),
      ...bars.map(() => element("div", { class: "tall" }, "new plans")),
      element("div", {}, "time [s]"));
    // The plan's are placed first: they are there in every jump.
    const isPlanned = ({ colour }) => colour === shown.rows[0]?.colour;
    const inOrder = shown.marks.filter(({ time }) => visible(time))
      .sort((a, b) => isPlanned(b) - isPlanned(a));
    const marks = inOrder.map(({ time, name, colour }) => {
      const mark = element("div", { class: "mark", title: name }, element("span", {}, name));
      Object.assign(mark.style, { left: percent(time), color: colour });
      return mark;
    });
    content.replaceChildren(...rows, scale(), ...marks);
    placeLabels(marks);
    placeRange();
    refresh();
    drawn();
  }

  function strip({ name, pieces }) {
    const row = element("div", { class: "row", title: name });
    for (const { start, end: until, colour, name: phase, low, feet } of pieces) {
      const width = clamp(share(until), 0, 1) - clamp(share(start), 0, 1);
      if (width <= 0) continue;
      const title = `${name}: ${phase}${feet ? ` (standing: ${feet})` : ""}`;
      const room = width * track.clientWidth, fits = (text) => LETTER * text.length + 6 < room;
      const label = !low && fits(phase) ? [element("span", {}, phase)] : [];
      if (feet && fits(`${phase} · ${feet}`))
        label.push(element("span", { class: "feet" }, ` · ${feet}`));
      const piece = element("div", { title, class: low ? "low" : "phase" }, ...label);
      Object.assign(piece.style, { left: percent(start), width: `${100 * width}%` });
      piece.style.setProperty("--colour", colour);
      row.append(piece);
    }
    return row;
  }

  // A strip of the times that planning anew took; its middle is the deadline.
  function computing(bars) {
    if (!bars.length) return [];
    const row = element("div", { class: "row bars", role: "img",
      "aria-label": `computing times of ${bars.length} new plans, ` +
        `${bars.filter((bar) => bar.in_time).length} in time` });
    for (const { time, height, in_time: inTime, words } of bars) {
      if (!visible(time)) continue;
      const bar = element("div", { class: inTime ? "bar in-time" : "bar", title: words });
      Object.assign(bar.style, { left: percent(time), height: `${Math.min(50 * height, 100)}%` });
      row.append(bar);
    }
    row.append(element("div", { class: "deadline" }));
    return [row];
  }

  function scale() {
    const [from, to] = inSight(), room = (track.clientWidth || 600) / TICK;
    const step = STEPS.find((each) => (to - from) / each <= room) ?? 10;
    const line = element("div", { class: "scale" });
    for (let n = Math.ceil(from / step + 0.2); n * step < to - 0.2 * step; n++) {
      const tick = element("span", {}, (n * step).toFixed(step < 0.1 ? 2 : step < 1 ? 1 : 0));
      tick.style.left = percent(n * step);
      line.append(tick);
    }
    return line;
  }

  // Each label right or left of its mark, in the first line where it lies over no other label and no
  // mark's line; where there is none, the mark's title has to do.
  function placeLabels(marks) {
    const { width } = track.getBoundingClientRect();
    const sizes = marks.map((mark) => mark.firstChild.offsetWidth + BESIDE + 2);
    const places = marks.map((mark) => (parseFloat(mark.style.left) / 100) * width);
    const labels = [], lines = []; // that are placed: {lane, left, right}, {lane, x}
    marks.forEach((mark, i) => {
      const x = places[i];
      const options = Array.from({ length: 2 * LANES }, (_, n) => ({
        lane: n >> 1, left: n % 2 ? x - sizes[i] : x, right: n % 2 ? x : x + sizes[i],
      }));
      const found = options.find(({ lane, left, right }) =>
        left >= 0 && right <= width
        && !labels.some((other) => other.lane === lane
          && left < other.right && other.left < right)
        && !labels.some((other) => other.lane > lane && other.left - 1 < x && x < other.right + 1)
        && !lines.some((line) => line.lane <= lane && left + BESIDE < line.x + 1
          && line.x - 1 < right - BESIDE));
      mark.firstChild.style.visibility = found ? "visible" : "hidden";
      const lane = found?.lane ?? LANES;
      mark.style.top = `${LANE * lane}px`;
      lines.push({ lane, x });
      if (found) labels.push(found);
      mark.classList.toggle("left", Boolean(found) && found.right === x);
    });
  }

  // On every frame: only what the browser can move without laying the bar out anew.
  function refresh() {
    if (!shown) return;
    const at = share(player.time);
    const inside = at >= -1e-6 && at <= 1 + 1e-6;
    if (!inside && player.playing && view) return look(player.time);
    cursor.style.display = inside ? "" : "none";
    cursor.style.transform = `translateX(${100 * at}%)`;
  }

  // ---- what is in sight

  // At a time, s, that has left the part in sight: the next part of the same length.
  function look(time) {
    const width = view[1] - view[0], from = clamp(time, 0, end() - width);
    setView([from, from + width]);
  }

  function setView(next) {
    const whole = !next || next[1] - next[0] >= end() - 1e-6;
    view = whole ? null : next;
    render();
    changed();
  }

  function zoom(factor, time) {
    const [from, to] = inSight(), width = clamp((to - from) * factor, NARROWEST, end());
    const start = clamp(time - share(time) * width, 0, end() - width);
    setView([start, start + width]);
  }

  // To the range, or where there is none to a quarter around the motion; and back.
  function toggleZoom() {
    if (view) return setView(null);
    if (player.range) return setView(range());
    zoom(0.25, clamp(player.time, 0, end()));
  }

  track.addEventListener("wheel", (event) => {
    if (!shown) return;
    event.preventDefault();
    const [from, to] = inSight(), { width } = track.getBoundingClientRect();
    const along = event.shiftKey ? event.deltaY || event.deltaX : event.deltaX;
    if (Math.abs(along) > Math.abs(event.shiftKey ? 0 : event.deltaY)) {
      const start = clamp(from + (along / width) * (to - from), 0, end() - (to - from));
      setView([start, start + to - from]);
    } else zoom(Math.exp(TURN * event.deltaY), timeAt(event.clientX));
  }, { passive: false });
  track.addEventListener("dblclick", (event) => {
    if (!event.target.closest(".handle, .shape")) setView(null);
  });

  // ---- the range that is played again and again

  function setRange(from, to) {
    const [low, high] = [clamp(from, 0, end()), clamp(to, 0, end())];
    const whole = low <= 1e-6 && high >= end() - 1e-6;
    player.setRange(whole || high - low < NARROWEST / 2 ? null : [low, high >= end() - 1e-6
      ? Infinity : high]);
    placeRange();
    changed();
  }

  function placeRange() {
    const times = range();
    outside[0].style.cssText = `left: 0; width: ${percent(times[0])}`;
    outside[1].style.cssText = `right: 0; left: ${percent(times[1])}`;
    handles.forEach((made, side) => {
      made.classList.toggle("rare", !player.range);
      made.style.left = percent(times[side]);
      made.style.display = visible(times[side]) ? "" : "none";
      made.setAttribute("aria-valuemax", end().toFixed(2));
      made.setAttribute("aria-valuenow", times[side].toFixed(2));
      made.setAttribute("aria-valuetext", `${times[side].toFixed(2)} s`);
    });
  }

  function handle(label, side) {
    const made = element("div", { class: "handle rare", role: "slider", tabindex: 0,
      "aria-label": label, "aria-valuemin": 0, title: `${label}: drag; a double-click: all` });
    const move = (time) => {
      const times = range(), other = times[1 - side];
      times[side] = side ? Math.max(time, other + NARROWEST) : Math.min(time, other - NARROWEST);
      setRange(...times);
    };
    made.addEventListener("pointerdown", (event) => {
      event.stopPropagation();
      made.setPointerCapture(event.pointerId);
    });
    made.addEventListener("pointermove", (event) => {
      if (made.hasPointerCapture(event.pointerId)) move(timeAt(event.clientX));
    });
    made.addEventListener("dblclick", () => setRange(0, end()));
    made.addEventListener("keydown", ({ key, shiftKey }) => {
      const by = { ArrowLeft: -FRAME, ArrowRight: FRAME }[key] * (shiftKey ? FAR : 1);
      if (by) move(range()[side] + by);
      else if (key === "Home" || key === "End") move(key === "Home" ? 0 : end());
    });
    return made;
  }

  // ---- scrubbing; with Shift a range is drawn instead

  let anchor = null; // s where a range begins
  track.addEventListener("pointerdown", (event) => {
    track.setPointerCapture(event.pointerId);
    anchor = event.shiftKey ? timeAt(event.clientX) : null;
    scrub(event);
  });
  track.addEventListener("pointermove", (event) => {
    if (track.hasPointerCapture(event.pointerId)) scrub(event);
  });
  function scrub({ clientX }) {
    const time = timeAt(clientX);
    if (anchor !== null) return setRange(Math.min(anchor, time), Math.max(anchor, time));
    player.goTo(time);
  }

  new ResizeObserver(render).observe(track);

  window.llsrbm.timeline = {
    style: STYLE,
    element: root,
    refresh, toggleZoom,
    show(timeline) {
      shown = timeline;
      root.style.display = "";
      if (view && view[1] > end()) view = null;
      render();
    },
    clear() {
      shown = view = null;
      root.style.display = "none";
    },
    onChange: (listener) => (changed = listener),
    // For the handles of the plan (shaping.js).
    track, percent, visible, timeBelow,
    top: LANES * LANE + 1, // of the first strip, pixels
    onDrawn: (listener) => (drawn = listener),
    get marks() { return (shown?.marks ?? []).map(({ time }) => time); },
    get perPixel() { return perPixel(); },
    get zoomed() { return view !== null; },
  };
})();
