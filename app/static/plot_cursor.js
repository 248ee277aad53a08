// The cursor of the plots and their values, drawn in the page: window.llsrbmPlots.show(time) moves
// the cursor in every chart in sight and writes beside each title the lines' values there;
// onPick(callback) passes on the time at which a user clicked. While the pointer is in a chart, a
// box beside it has all lines by name with their units, and all titles have the values there.
// missing() names what this needs of viser and does not find.
//
// viser keeps its uPlot charts in window.__viserTestpoints.uplots and makes them anew as it likes,
// so nothing is kept here but what hangs on a chart. What viser leaves undone is mended here as well.
(() => {
  if (window.llsrbmPlots) return;

  const VALUES_EVERY = 100; // ms; numbers that change faster cannot be read
  const DRESSED_EVERY = 300; // ms; until then a new chart may lack its cursor while nothing plays
  const CLICK = 4; // pixels; a longer way is a drag, by which uPlot zooms
  const LINES = "y"; // scale of the series that are no marks
  const ASIDE = "4,4"; // dashes of limits and second curves: in the box alone
  const MOST = 6; // values beside a title
  const BESIDE = 14; // pixels from the pointer to the box
  // What is used of a chart.
  const CHART = ["axes", "bbox", "cursor", "data", "height", "hooks", "over", "posToVal", "redraw",
    "root", "scales", "series", "setScale", "valToIdx", "valToPos", "width"];

  const dressings = new WeakMap(); // chart -> its elements
  const listeners = [];
  let shown = null; // s; null until there is a motion
  let valuesAt = -Infinity; // performance.now() of the last numbers
  let pending = 0; // timer of the numbers that were put off
  let pointed = null; // the chart that the pointer is in

  const { element, write, lacking } = window.llsrbm;
  document.head.append(element("style", {}, `
    .uplot .u-title { text-align: left; padding: 3px 8px 0; font-size: 11.5px; position: relative;
      white-space: nowrap; overflow: hidden; line-height: 1.5; }
    .llsrbm-values { position: absolute; right: 0; top: 3px; padding: 0 8px 0 0.3em; font-weight: 400;
      font-variant-numeric: tabular-nums; background: var(--mantine-color-body); }
    .llsrbm-values span:not(:first-child) { margin-left: 0.7em; }
    .uplot-container:is(:hover, :focus-within) .llsrbm-values { right: 104px; }
    .llsrbm-copy { position: absolute; right: 30px; top: 2px; opacity: 0; } /* viser: expands */
    .uplot-container:is(:hover, :focus-within) .llsrbm-copy { opacity: 1; }
    .llsrbm-copy button { font-size: 10px; line-height: 15px; padding: 0 5px; margin-left: 3px;
      cursor: pointer; color: inherit; background: var(--mantine-color-default);
      border: 1px solid var(--mantine-color-default-border); border-radius: 3px; }
    .llsrbm-cursor { position: absolute; left: 0; top: 0; bottom: 0; width: 0; pointer-events: none;
      border-left: 1.5px solid var(--mantine-color-text); opacity: 0.75; z-index: 90;
      will-change: transform; }
    .llsrbm-hover { position: fixed; left: 0; top: 0; z-index: 300; pointer-events: none; display: none;
      padding: 4px 8px; border-radius: 4px; font: 11.5px/1.45 system-ui, sans-serif;
      font-variant-numeric: tabular-nums; color: var(--mantine-color-text);
      background: var(--mantine-color-body); border: 1px solid var(--mantine-color-default-border);
      box-shadow: 0 2px 8px rgba(0, 0, 0, 0.2); }
    .llsrbm-hover table { border-collapse: collapse; }
    .llsrbm-hover td { padding: 0 0 0 0.8em; text-align: right; white-space: nowrap; }
    .llsrbm-hover td:first-child { padding: 0; text-align: left; }
    .llsrbm-hover td:last-child { padding-left: 0.3em; text-align: left; }`));
  const box = element("div", { class: "llsrbm-hover" });
  document.body.append(box);

  function charts() {
    const known = window.__viserTestpoints?.uplots;
    return known ? Object.values(known).map((entry) => entry.chart) : [];
  }

  // A line's colour as that of letters, by day and by night.
  const readable = (colour) => `color-mix(in srgb, ${colour} 60%, var(--mantine-color-text))`;

  function dress(chart) {
    const cursor = element("div", { class: "llsrbm-cursor" });
    chart.over.append(cursor);
    const values = element("div", { class: "llsrbm-values" });
    chart.root.querySelector(".u-title")?.append(values);
    const copy = element("div", { class: "llsrbm-copy" });
    copy.append(...window.llsrbm.plotFigure.buttons(chart));
    chart.root.querySelector(".u-title")?.append(copy);
    window.llsrbm.plotZoom(chart);
    window.llsrbm.plotDrag(chart);
    const lines = chart.series.flatMap((series, index) => {
      if (series.scale !== LINES) return [];
      const colour = typeof series.stroke === "function" ? series.stroke(chart, index) : series.stroke;
      return [{ index, colour, name: series.label, aside: String(series.dash) === ASIDE }];
    });
    const beside = lines.filter((line) => !line.aside);
    for (const line of beside.length > MOST ? [] : beside) {
      line.value = element("span", { title: line.name });
      line.value.style.color = readable(line.colour);
      values.append(line.value);
    }
    const dressing = { cursor, values, lines, pressedAt: null, mended: null };
    dressings.set(chart, dressing);
    chart.over.addEventListener("mousedown", (event) => {
      dressing.pressedAt = [event.clientX, event.clientY];
    });
    chart.over.addEventListener("click", (event) => {
      const from = dressing.pressedAt ?? [event.clientX, event.clientY];
      if (Math.hypot(event.clientX - from[0], event.clientY - from[1]) > CLICK) return;
      const time = chart.posToVal(event.clientX - chart.over.getBoundingClientRect().left, "x");
      if (Number.isFinite(time)) listeners.forEach((listener) => listener(Math.max(time, 0)));
    });
    // A zoom is every chart's, and so is its end.
    chart.over.addEventListener("dblclick", () => dressed().forEach(([other]) => {
      const times = other.data[0];
      other.setScale("x", { min: times[0], max: times[times.length - 1] });
    }));
    chart.over.addEventListener("mousemove", (event) => {
      pointed = chart;
      putOffValues();
      hover(chart, dressing, event);
    });
    chart.over.addEventListener("mouseleave", () => {
      pointed = null;
      putOffValues();
      box.style.display = "none";
    });
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

  function place(chart, { cursor }) {
    const { min, max } = chart.scales.x;
    const inside = shown != null && min != null && shown >= min && shown <= max;
    cursor.style.display = inside ? "" : "none";
    if (inside) cursor.style.transform = `translateX(${chart.valToPos(shown, "x").toFixed(1)}px)`;
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
    const pointedAt = pointed && chart.cursor.idx != null ? chart.cursor.idx : null;
    const index = pointedAt ?? (shown == null ? -1 : chart.valToIdx(shown));
    const digits = digitsOf(chart);
    for (const line of lines) {
      if (line.value) write(line.value, written(chart.data[line.index]?.[index], digits));
    }
  }

  // All lines at the pointer, by name.
  function hover(chart, { lines }, event) {
    const index = chart.cursor.idx;
    if (index == null) return;
    const heading = chart.root.querySelector(".u-title")?.firstChild?.textContent ?? "";
    const unit = /\[([^\]]*)\]$/.exec(heading)?.[1] ?? "";
    const digits = digitsOf(chart);
    const table = element("table");
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
    const { offsetWidth: width, offsetHeight: height } = box;
    const right = event.clientX + BESIDE + width < window.innerWidth;
    const x = right ? event.clientX + BESIDE : event.clientX - BESIDE - width;
    const under = event.clientY + BESIDE + height < window.innerHeight;
    const y = under ? event.clientY + BESIDE : event.clientY - BESIDE - height;
    box.style.transform = `translate(${Math.max(x, 0)}px, ${Math.max(y, 0)}px)`;
  }

  // On every frame: a size is only asked for of charts that are new, for then the page is laid out.
  function dressed() {
    return charts().filter((chart) => chart.root.isConnected
      && (dressings.has(chart) || chart.over.clientWidth > 0))
      .map((chart) => [chart, dressings.get(chart) ?? dress(chart)]);
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

  setInterval(() => {
    dressed();
    // A chart that goes away under the pointer is not left by it.
    if (pointed && !pointed.root.isConnected) {
      pointed = null;
      box.style.display = "none";
    }
  }, DRESSED_EVERY);

  // Charts are known only as long as there are any: a page without one lacks nothing of them.
  function missing() {
    const names = lacking(window,
      ["__viserMutable.canvas", "__viserMutable.sendMessage", "__viserTestpoints"]);
    const known = window.__viserTestpoints?.uplots;
    if (!known && document.querySelector(".uplot")) names.push("__viserTestpoints.uplots");
    const fields = Object.values(known ?? {}).flatMap((entry) =>
      entry.chart ? lacking(entry.chart, CHART) : ["chart"]);
    return [...names, ...new Set(fields.map((field) => `__viserTestpoints.uplots: ${field}`))];
  }

  window.llsrbmPlots = {
    missing,
    show(time) {
      shown = time;
      dressed().forEach(([chart, dressing]) => place(chart, dressing));
      putOffValues();
    },
    onPick(listener) {
      listeners.push(listener);
    },
  };
})();
