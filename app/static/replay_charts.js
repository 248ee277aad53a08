// The charts of a replay, in the bar below its picture: lines over time, a cursor where the motion is,
// and the values there. A press or a drag goes to that instant. Lines come from app/replay.py.
(() => {
  const { player, element, swatch, shape, write, addToPage } = window.llsrbm;
  const WIDE = 400, HIGH = 100; // units of a drawing, which is stretched
  const ROOM = [820, 600]; // pixels of a window in which they are open at first

  const STYLE = `
    #llsrbm-charts { margin-bottom: 4px; border-bottom: 1px solid var(--mantine-color-default-border); }
    #llsrbm-charts summary { cursor: pointer; width: max-content; }
    #llsrbm-charts .all { display: grid; gap: 4px 14px; padding-bottom: 5px;
      grid-template-columns: repeat(auto-fit, minmax(180px, 1fr)); }
    #llsrbm-charts figure { margin: 0; min-width: 0; }
    #llsrbm-charts figcaption { display: flex; flex-wrap: wrap; gap: 0 8px; line-height: 1.35;
      font-variant-numeric: tabular-nums; }
    #llsrbm-charts .area { position: relative; height: 76px; cursor: ew-resize; touch-action: none;
      background: var(--mantine-color-default); border-radius: 3px; overflow: hidden; }
    #llsrbm-charts svg { position: absolute; inset: 0; width: 100%; height: 100%; }
    #llsrbm-charts path { fill: none; stroke-width: 1.6; vector-effect: non-scaling-stroke; }
    #llsrbm-charts rect { fill: currentColor; opacity: 0.09; }
    #llsrbm-charts .end { position: absolute; left: 3px; line-height: 1; pointer-events: none;
      padding: 1px; background: var(--mantine-color-default); }
    #llsrbm-charts .now { position: absolute; top: 0; bottom: 0; width: 0; pointer-events: none;
      border-left: 1.5px solid currentColor; }
    #llsrbm-charts i { display: inline-block; width: 10px; height: 3px; vertical-align: middle;
      margin-right: 4px; }`;

  const plain = (value) => (value == null ? "–" : Number(value.toPrecision(3)).toString().replace("-", "−"));
  let drawn = [], time = [], end = 1;

  function area(lines, flights) {
    const all = lines.flatMap(({ values }) => values.filter((value) => value !== null));
    let [low, high] = [Math.min(...all), Math.max(...all)];
    const pad = 0.08 * (high - low) || 0.1 * Math.abs(high) || 1;
    [low, high] = [low - pad, high + pad];
    const x = (t) => (WIDE * t) / end, y = (value) => HIGH * (1 - (value - low) / (high - low));
    const path = (values) => values.map((value, i) => (value === null ? ""
      : `${i && values[i - 1] !== null ? "L" : "M"}${x(time[i]).toFixed(1)} ${y(value).toFixed(1)}`)).join("");
    const now = element("div", { class: "now" });
    const made = element("div", { class: "area", onpointerdown: seek, onpointermove: seek },
      shape("svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, preserveAspectRatio: "none", "aria-hidden": "true" },
        ...flights.map(([from, to]) =>
          shape("rect", { x: x(from), y: 0, width: x(to) - x(from), height: HIGH })),
        ...lines.map(({ values, colour, dash }) => shape("path", { d: path(values), stroke: colour,
          "stroke-dasharray": dash.join(" ") }))), now);
    for (const [edge, value] of [["top", high - pad], ["bottom", low + pad]]) {
      const label = element("span", { class: "end" }, plain(value));
      label.style[edge] = "3px";
      made.append(label);
    }
    return [made, now];
  }

  function seek(event) {
    if (event.type === "pointermove" && !(event.buttons & 1)) return;
    const box = event.currentTarget.getBoundingClientRect();
    if (event.type === "pointerdown") event.currentTarget.setPointerCapture(event.pointerId);
    player.goTo(end * Math.min(1, Math.max(0, (event.clientX - box.left) / box.width)));
  }

  function chart({ title, lines }, flights) {
    const [made, now] = area(lines, flights), values = lines.map(() => element("span", {}, " "));
    const keys = lines.map(({ colour, name }, i) =>
      element("span", { title: name }, swatch(colour), values[i]));
    drawn.push({ now, lines, values });
    return element("figure", {}, element("figcaption", {}, element("b", {}, title), ...keys), made);
  }

  function refresh() {
    const index = Math.max(0, time.findLastIndex((t) => t <= player.time));
    for (const { now, lines, values } of drawn) {
      now.style.left = `${(100 * player.time) / end}%`;
      lines.forEach((line, i) => write(values[i], plain(line.values[index])));
    }
  }

  const grid = element("div", { class: "all" });
  const charts = element("details", { id: "llsrbm-charts" },
    element("summary", {}, "Charts"), grid);
  addToPage(STYLE);
  player.listen(refresh);

  window.llsrbm.charts = {
    // Instants, s; spans of flight; charts with their lines, which have a value or null an instant.
    show(figure) {
      [time, end, drawn] = [figure.time, player.clip.end, []];
      grid.replaceChildren(...figure.charts.map((each) => chart(each, figure.flights)));
      charts.open = innerWidth >= ROOM[0] && innerHeight >= ROOM[1];
      document.getElementById("llsrbm-transport").prepend(charts);
      refresh();
    },
  };
})();
