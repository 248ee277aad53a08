// The cursor of the plots, drawn in the page: window.llsrbmPlots.show(time) moves it in every chart
// in sight and writes beside each title what the lines are there; onPick(callback) tells the time at
// which a user clicked. While the pointer is in a chart, the values are those under it.
//
// viser keeps its uPlot charts in window.__viserTestpoints.uplots and makes them anew as it likes,
// so nothing is kept here but what hangs on a chart. What viser leaves undone is mended here as well.
(() => {
  if (window.llsrbmPlots) return;

  const VALUES_EVERY = 100; // ms; numbers that change faster cannot be read
  const DRESSED_EVERY = 300; // ms; until then a new chart may lack its cursor while nothing plays
  const CLICK = 4; // pixels; a longer way is a drag, by which uPlot zooms
  const FIRST_LINE_SCALE = "y"; // of the series that are no marks

  const dressings = new WeakMap(); // chart -> its elements
  const listeners = [];
  let shown = null; // s; null until somebody says what is shown
  let valuesAt = -Infinity; // performance.now() of the last numbers
  let pending = 0; // timer of the numbers that were put off
  let pointed = false; // whether the pointer is in a chart

  const style = document.createElement("style");
  style.textContent = `
    .uplot .u-title { text-align: left; padding: 3px 8px 0; font-size: 11.5px; position: relative;
      white-space: nowrap; overflow: hidden; line-height: 1.5; }
    .llsrbm-values { position: absolute; right: 0; top: 3px; padding: 0 8px 0 0.3em; font-weight: 400;
      font-variant-numeric: tabular-nums; background: var(--mantine-color-body); }
    .llsrbm-values span:not(:first-child) { margin-left: 0.7em; }
    .uplot-container:hover .llsrbm-values { right: 30px; } /* viser: a button to expand the chart */
    .llsrbm-cursor { position: absolute; left: 0; top: 0; bottom: 0; width: 0; pointer-events: none;
      border-left: 1.5px solid var(--mantine-color-text); opacity: 0.75; z-index: 90;
      will-change: transform; }`;
  document.head.appendChild(style);

  function charts() {
    const known = window.__viserTestpoints?.uplots;
    return known ? Object.values(known).map((entry) => entry.chart) : [];
  }

  function dress(chart) {
    const cursor = document.createElement("div");
    cursor.className = "llsrbm-cursor";
    chart.over.appendChild(cursor);
    const values = document.createElement("div");
    values.className = "llsrbm-values";
    chart.root.querySelector(".u-title")?.appendChild(values);
    const lines = chart.series.flatMap((series, index) => {
      if (series.scale !== FIRST_LINE_SCALE || series.dash) return [];
      const value = document.createElement("span");
      value.title = series.label;
      value.style.color = typeof series.stroke === "function" ? series.stroke(chart, index) : series.stroke;
      values.appendChild(value);
      return [{ index, value }];
    });
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
    chart.over.addEventListener("mousemove", () => { pointed = true; putOffValues(); });
    chart.over.addEventListener("mouseleave", () => { pointed = false; putOffValues(); });
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

  function write(chart, { lines }) {
    const pointedAt = pointed && chart.cursor.idx != null ? chart.cursor.idx : null;
    const index = pointedAt ?? (shown == null ? -1 : chart.valToIdx(shown));
    const { min, max } = chart.scales.y;
    const digits = min == null ? 2 : Math.min(Math.max(2 - Math.floor(Math.log10(max - min || 1)), 0), 4);
    for (const line of lines) {
      const number = chart.data[line.index]?.[index];
      line.value.textContent = Number.isFinite(number) ? number.toFixed(digits) : "";
    }
  }

  function dressed() {
    return charts().filter((chart) => chart.root.isConnected && chart.over.clientWidth > 0)
      .map((chart) => [chart, dressings.get(chart) ?? dress(chart)]);
  }

  function writeAll() {
    clearTimeout(pending);
    pending = 0;
    valuesAt = performance.now();
    dressed().forEach(([chart, dressing]) => write(chart, dressing));
  }

  function putOffValues() {
    const wait = VALUES_EVERY - (performance.now() - valuesAt);
    pending ||= setTimeout(writeAll, Math.max(wait, 0));
  }

  setInterval(dressed, DRESSED_EVERY);

  window.llsrbmPlots = {
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
