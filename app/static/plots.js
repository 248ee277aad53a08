// The plots: viser's floating panel with the charts is kept below the picture, as wide as it. Each
// chart gets a cursor where the motion is, values beside its title and under the pointer, a zoom,
// buttons that copy it (plot_figure.js), and can be dragged onto another one. viser makes its charts
// (window.__viserTestpoints.uplots) anew as it likes: nothing is kept but what hangs on a chart.
(() => {
  const { page, player, layout, element, write, lacking, addToPage } = window.llsrbm;

  const MARKER = ".llsrbm-plot-area"; // in the panel's own HTML (app/plots/plots.py)
  const FLOATING = "[data-floating-window]";
  const PINNED = "data-llsrbm-pinned", GRID = "data-llsrbm-charts";
  const SMALLEST = [1100, 700]; // pixels of a page in which the area is open at first
  const VALUES_EVERY = 100; // ms; numbers that change faster cannot be read
  const CLICK = 4; // pixels; a longer way is a drag, by which uPlot zooms
  const MOST = 6; // values beside a title
  const BESIDE = 14; // pixels from the pointer to the box
  const TURN = 0.0015; // zoom of a wheel, a pixel
  const DRAGGED = "application/x-llsrbm-chart"; // its title; null: what is on offer
  const ONTO = "llsrbm-onto";
  // The parts of a chart that are used.
  const CHART = ["axes", "bbox", "cursor", "data", "height", "hooks", "over", "posToVal", "redraw",
    "root", "scales", "series", "setScale", "valToIdx", "valToPos", "width"];

  const STYLE = `
    [${PINNED}] { left: var(--llsrbm-left) !important; width: var(--llsrbm-width) !important;
      top: auto !important; bottom: 0 !important; border-radius: 0 !important; z-index: 6 !important;
      box-shadow: none !important; border-top: 1px solid var(--mantine-color-default-border); }
    [${PINNED}] [data-dock-strip] { display: none !important; }
    [${PINNED}]:not([style*="height"]) .mantine-ScrollArea-viewport { max-height: 46vh; }
    [${GRID}] { display: grid; align-items: start; padding-bottom: 4px;
      grid-template-columns: repeat(auto-fit, minmax(min(100%, max(250px, var(--least, 0px))), 1fr)); }
    [${GRID}]:has(> :nth-child(3):last-child) { --least: 40%; } /* of two charts, three, four */
    [${GRID}]:has(> :nth-child(4):last-child) { --least: 30%; }
    [${GRID}]:has(> :nth-child(5):last-child) { --least: 22%; }
    [${GRID}] > * { min-width: 0; }
    [${GRID}] > :has(${MARKER}) { grid-column: 1 / -1; position: sticky; top: 0; z-index: 110;
      background: var(--mantine-color-body); }
    [${GRID}] .uplot-container { margin: 0 6px 6px; }
    /* Doubled: viser's own rule may come later. */
    .uplot .u-title.u-title { padding: 3px 8px 0; overflow: hidden; white-space: nowrap;
      font-size: 12px; line-height: 1.5; text-align: left; position: relative; }
    .uplot .u-title[draggable=true] { cursor: grab; }
    .${ONTO} { outline: 2px dashed var(--mantine-primary-color-filled); outline-offset: -2px; }
    .llsrbm-values { position: absolute; right: 0; top: 3px; padding: 0 8px 0 0.3em; font-weight: 400;
      font-variant-numeric: tabular-nums; background: var(--mantine-color-body); }
    .llsrbm-values span:not(:first-child) { margin-left: 0.7em; }
    .uplot-container:is(:hover, :focus-within) .llsrbm-values { right: 118px; }
    .llsrbm-copy { position: absolute; right: 30px; top: 2px; opacity: 0; } /* viser: expands */
    .uplot-container:is(:hover, :focus-within) .llsrbm-copy { opacity: 1; }
    .llsrbm-copy button { font-size: 12px; line-height: 15px; padding: 0 5px; margin-left: 3px;
      cursor: pointer; color: inherit; background: var(--mantine-color-default);
      border: 1px solid var(--mantine-color-default-border); border-radius: 3px; }
    .llsrbm-cursor { position: absolute; left: 0; top: 0; bottom: 0; width: 0; pointer-events: none;
      border-left: 1.5px solid var(--mantine-color-text); opacity: 0.75; z-index: 90;
      will-change: transform; }
    .llsrbm-hover { position: fixed; left: 0; top: 0; z-index: 300; pointer-events: none; display: none;
      padding: 4px 8px; border-radius: 4px; font: 12px/1.45 system-ui, sans-serif;
      font-variant-numeric: tabular-nums; color: var(--mantine-color-text);
      background: var(--mantine-color-body); border: 1px solid var(--mantine-color-default-border);
      box-shadow: 0 2px 8px rgba(0, 0, 0, 0.2); }
    .llsrbm-hover table { border-collapse: collapse; }
    .llsrbm-hover td { padding: 0 0 0 0.8em; text-align: right; white-space: nowrap; }
    .llsrbm-hover td:is(:first-child, :last-child) { padding-left: 0.3em; text-align: left; }`;

  // ---- the area

  let watched = null; // the panel's title, and the server's controls: see `watch`
  let pinned = null; // viser's window of the area
  let seen = null; // whether the area was seen; null: not yet

  // The box of viser's that has the picture.
  const holder = () => [...(document.querySelector("[data-dock-root]")?.children ?? [])].find(
    (child) => child.contains(window.__viserMutable?.canvas ?? null)) ?? null;

  const set = (uuid, value) => window.__viserMutable?.sendMessage(
    { type: "GuiUpdateMessage", uuid, updates: { value } });

  // A minimised panel has nothing but its title.
  const minimised = () => [...document.querySelectorAll(FLOATING)].find((panel) =>
    panel.querySelector("[data-dock-tab]")?.textContent === watched?.title) ?? null;

  function look() {
    const marker = document.querySelector(MARKER);
    const found = marker ? marker.closest(FLOATING) : minimised();
    if (found !== pinned) {
      pinned?.removeAttribute(PINNED);
      pinned = found;
      pinned?.setAttribute(PINNED, "");
      layout.watch(pinned);
    }
    layout.watch(holder());
    arrange(marker);
    placeArea();
    if (watched) draggable(document.getElementById(watched.add), () => null);
    const visible = Boolean(marker?.getClientRects().length);
    if (watched && seen !== null && visible !== seen) set(watched.seen, visible);
    if (visible || seen !== null) seen = visible;
    dressed();
    // A chart that goes away under the pointer is not left by it.
    if (pointed && !pointed.root.isConnected) leave();
  }

  // Whatever holds the legend and the charts is a grid.
  function arrange(marker) {
    let around = marker;
    while (around && !around.querySelector(".uplot-container")) around = around.parentElement;
    if (around && !around.contains(holder())) around.setAttribute(GRID, "");
  }

  function placeArea() {
    const wrap = holder();
    if (!wrap) return;
    const below = `${(pinned?.isConnected && pinned.offsetHeight) || window.llsrbm.sheet.height}px`;
    if (wrap.style.bottom !== below) wrap.style.bottom = below;
    pinned?.style.setProperty("--llsrbm-left", `${wrap.offsetLeft}px`);
    pinned?.style.setProperty("--llsrbm-width", `${wrap.offsetWidth}px`);
  }

  // ---- charts

  const dressings = new WeakMap(); // chart -> its elements
  let shown = null; // s; null until there is a motion
  let valuesAt = -Infinity, pending = 0; // time of the last numbers; timer of those put off
  let pointed = null; // the chart that the pointer is in
  const box = element("div", { class: "llsrbm-hover" });

  const charts = () =>
    Object.values(window.__viserTestpoints?.uplots ?? {}).map((entry) => entry.chart);

  // On every frame: a size is only asked for of charts that are new, for then the page is laid out.
  function dressed() {
    return charts().filter((chart) => {
      if (!chart.root.isConnected) return false;
      if (dressings.has(chart) || chart.over.clientWidth > 0) return true;
      layout.watch(chart.root);
      return false;
    }).map((chart) => [chart, dressings.get(chart) ?? dress(chart)]);
  }

  const titleOf = (chart) => chart.root.querySelector(".u-title")?.firstChild?.textContent ?? "";

  // The lines of one kind, "mark" or "curve"; `aside`: no motion's own, but a limit, or a second one.
  const linesOf = (chart, kind) => chart.series.flatMap((series, index) => {
    const [is, ...more] = (series.class ?? "").split(" ");
    if (is !== kind) return [];
    const colour = typeof series.stroke === "function" ? series.stroke(chart, index) : series.stroke;
    return [{ index, colour, dash: series.dash, name: series.label, aside: more.includes("aside") }];
  });

  // As the colour of letters, by day and by night: 4.5 : 1 of the darkest by night, too.
  const readable = (colour) => `color-mix(in srgb, ${colour} 40%, var(--mantine-color-text))`;

  function dress(chart) {
    const { over, root } = chart, title = root.querySelector(".u-title");
    const cursor = element("div", { class: "llsrbm-cursor" });
    const values = element("div", { class: "llsrbm-values" });
    over.append(cursor);
    title?.append(values,
      element("div", { class: "llsrbm-copy" }, ...window.llsrbm.plotFigure.buttons(chart)));
    const lines = linesOf(chart, "curve"), beside = lines.filter((line) => !line.aside);
    for (const line of beside.length > MOST ? [] : beside) {
      line.value = element("span", { title: line.name });
      line.value.style.color = readable(line.colour);
      values.append(line.value);
    }
    const dressing = { cursor, lines, pressedAt: null, mended: null };
    dressings.set(chart, dressing);
    followPointer(chart, dressing);
    zoomable(chart);
    draggable(title, () => titleOf(chart));
    takesDrops(chart);
    // Other data, another size, a zoom: whatever draws the chart moves the cursor as well.
    const drawn = () => {
      place(chart, dressing);
      putOffValues();
      mend(chart, dressing);
    };
    (chart.hooks.draw ??= []).push(drawn);
    drawn();
    return dressing;
  }

  // viser passes new data on by uPlot's redraw(), which forgets that axes wait to be laid out anew
  // when the chart was measured in the same turn: it would stay without its time axis.
  function mend(chart, dressing) {
    const size = `${chart.width} ${chart.height}`;
    const lost = chart.axes.some((axis) => axis.show && axis._values == null);
    if (!lost || !(chart.bbox.width > 0) || dressing.mended === size) return;
    dressing.mended = size;
    chart.redraw(false, true);
  }

  // ---- cursor and values

  function place(chart, { cursor }) {
    const { min, max } = chart.scales.x;
    const inside = shown != null && min != null && shown >= min && shown <= max;
    cursor.style.display = inside ? "" : "none";
    if (inside) cursor.style.transform = `translateX(${chart.valToPos(shown, "x").toFixed(1)}px)`;
  }

  function show(time) {
    shown = time;
    dressed().forEach(([chart, dressing]) => place(chart, dressing));
    putOffValues();
  }

  function digitsOf({ scales }) {
    const { min, max } = scales.y;
    return min == null ? 2 : Math.min(Math.max(2 - Math.floor(Math.log10(max - min || 1)), 0), 4);
  }

  function written(number, digits) {
    if (!Number.isFinite(number)) return "";
    const text = number.toFixed(digits);
    return Number(text) === 0 ? text.replace("-", "") : text;
  }

  function writeValues(chart, { lines }) {
    const pointedAt = pointed ? chart.cursor.idx : null, digits = digitsOf(chart);
    const index = pointedAt ?? (shown == null ? -1 : chart.valToIdx(shown));
    for (const line of lines) {
      if (line.value) write(line.value, written(chart.data[line.index]?.[index], digits));
    }
  }

  function writeAll() {
    clearTimeout(pending);
    pending = 0;
    valuesAt = performance.now();
    dressed().forEach(([chart, dressing]) => writeValues(chart, dressing));
  }

  function putOffValues() {
    const wait = VALUES_EVERY - (performance.now() - valuesAt);
    pending ||= setTimeout(writeAll, Math.max(wait, 0));
  }

  // All lines at the pointer, by name.
  function hover(chart, { lines }, event) {
    const index = chart.cursor.idx;
    if (index == null) return;
    const unit = /\[([^\]]*)\]$/.exec(titleOf(chart))?.[1] ?? "";
    const digits = digitsOf(chart), table = element("table");
    const row = (name, value, units, colour) => {
      const cells = [name, value, units].map((text) => element("td", {}, text));
      if (colour) cells[0].style.color = readable(colour);
      table.append(element("tr", {}, ...cells));
    };
    row("time", chart.data[0][index].toFixed(3), "s");
    for (const { index: line, name, colour } of lines) {
      const value = written(chart.data[line]?.[index], digits);
      if (value) row(name, value, unit, colour);
    }
    box.replaceChildren(table);
    box.style.display = "block";
    const beside = (at, size, room) =>
      Math.max(0, at + BESIDE + size < room ? at + BESIDE : at - BESIDE - size);
    box.style.transform = `translate(${beside(event.clientX, box.offsetWidth, innerWidth)}px, ` +
      `${beside(event.clientY, box.offsetHeight, innerHeight)}px)`;
  }

  function leave() {
    pointed = null;
    putOffValues();
    box.style.display = "none";
  }

  // A click goes to its instant.
  function followPointer(chart, dressing) {
    const { over } = chart;
    over.addEventListener("mousedown", (event) => {
      dressing.pressedAt = [event.clientX, event.clientY];
    });
    over.addEventListener("click", (event) => {
      const from = dressing.pressedAt ?? [event.clientX, event.clientY];
      if (Math.hypot(event.clientX - from[0], event.clientY - from[1]) > CLICK) return;
      const time = chart.posToVal(event.clientX - over.getBoundingClientRect().left, "x");
      if (!Number.isFinite(time)) return;
      player.goTo(time);
    });
    over.addEventListener("mousemove", (event) => {
      pointed = chart;
      putOffValues();
      hover(chart, dressing, event);
    });
    over.addEventListener("mouseleave", leave);
  }

  // ---- zoom: the wheel over a chart's upright axis, or with Shift over its curves, zooms; dragging
  // the axis shifts; a double-click shows all again

  function zoomable(chart) {
    const { over } = chart;
    // A zoom in time is every chart's, and so is its end.
    over.addEventListener("dblclick", () => dressed().forEach(([other]) => {
      const times = other.data[0];
      other.setScale("x", { min: times[0], max: times[times.length - 1] });
    }));
    const scale = chart.scales.y, axis = chart.root.querySelectorAll(".u-axis")[1];
    if (!scale || !axis) return;
    const automatic = scale.range;
    let chosen = null; // [least, most] that are shown; null: as the curves need
    // Asked on every drawing, so that a zoom outlives other data.
    scale.range = (...given) => chosen ?? automatic(...given);

    function choose(next) {
      chosen = next;
      if (next) chart.setScale("y", { min: next[0], max: next[1] });
      else chart.setScale("x", { min: chart.scales.x.min, max: chart.scales.x.max });
    }

    function zoom(event) {
      const { top, height } = over.getBoundingClientRect();
      const { min, max } = scale, factor = Math.exp(TURN * (event.deltaY || event.deltaX));
      const at = max - ((event.clientY - top) / height) * (max - min);
      event.preventDefault();
      choose([at + factor * (min - at), at + factor * (max - at)]);
    }

    axis.title = "Turn the wheel or drag: zoom. Double-click: all";
    Object.assign(axis.style, { cursor: "ns-resize", touchAction: "none" });
    axis.addEventListener("wheel", zoom, { passive: false });
    over.addEventListener("wheel", (event) => event.shiftKey && zoom(event), { passive: false });
    let from = null; // clientY and range where a drag began
    axis.addEventListener("pointerdown", (event) => {
      axis.setPointerCapture(event.pointerId);
      from = [event.clientY, scale.min, scale.max];
    });
    axis.addEventListener("pointermove", (event) => {
      if (!axis.hasPointerCapture(event.pointerId)) return;
      const [start, min, max] = from;
      const by = ((event.clientY - start) / over.clientHeight) * (max - min);
      if (by) choose([min + by, max + by]);
    });
    axis.addEventListener("dblclick", () => choose(null));
    over.addEventListener("dblclick", () => chosen && choose(null));
  }

  // ---- a chart's title, or the button that adds a chart, dragged onto a chart: they share it

  function draggable(thing, title) {
    if (!thing || thing.draggable) return;
    thing.draggable = true;
    thing.addEventListener("dragstart", (event) => {
      event.dataTransfer.setData(DRAGGED, JSON.stringify(title()));
      event.dataTransfer.effectAllowed = "move";
    });
  }

  function takesDrops(chart) {
    const { root } = chart, isChart = (event) => event.dataTransfer.types.includes(DRAGGED);
    root.addEventListener("dragover", (event) => {
      if (!isChart(event)) return;
      event.preventDefault();
      root.classList.add(ONTO);
    });
    root.addEventListener("dragleave", (event) => {
      if (!root.contains(event.relatedTarget)) root.classList.remove(ONTO);
    });
    root.addEventListener("drop", (event) => {
      root.classList.remove(ONTO);
      if (!isChart(event)) return;
      event.preventDefault();
      const dropped = JSON.parse(event.dataTransfer.getData(DRAGGED));
      page.send({ kind: "chart", chart: dropped, onto: titleOf(chart) });
    });
  }

  // ---- the other scripts

  // Charts are known only as long as there are any: a page without one lacks nothing of them.
  function missing() {
    const names = lacking(window, ["__viserMutable.canvas", "__viserTestpoints"]);
    const known = window.__viserTestpoints?.uplots;
    if (!known && document.querySelector(".uplot")) names.push("__viserTestpoints.uplots");
    const fields = Object.values(known ?? {}).flatMap((entry) =>
      entry.chart ? lacking(entry.chart, CHART) : ["chart"]);
    return [...names, ...new Set(fields.map((field) => `__viserTestpoints.uplots: ${field}`))];
  }

  window.llsrbm.require(missing);
  addToPage(STYLE, box);
  layout.onChange(look);
  layout.onMove(() => {
    placeArea();
    dressed();
  });
  player.listen(() => show(player.time));

  window.llsrbm.plots = {
    show, missing, linesOf, titleOf,
    // Controls of the server's: `open` opens the area, `seen` says whether it is, `add` adds charts.
    watch(title, open, shownBox, add) {
      watched = { title, seen: shownBox, add };
      seen = null;
      look();
      if (window.innerWidth < SMALLEST[0] || window.innerHeight < SMALLEST[1]) set(open, false);
    },
  };
})();
