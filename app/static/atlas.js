// The map of the atlas: its cells and the place of the present design come from the server
// (app/panel/atlas_controls.py). The pointer or the arrow keys choose a cell, whose jump is described
// below the map; a click or Enter opens it. A drawer over the picture has the map at full width.
(() => {
  const { page, layout, element, shape, addToPage } = window.llsrbm;
  const PLACE = ".llsrbm-atlas";
  const REQUEST_EVERY = 3000; // ms until a server that has sent no map is requested again
  const IN_PANEL = [320, 250]; // width and height of the map, which grows with the panel
  const AROUND = [20, 130], LEAST = 220; // pixels of the drawer around its map; of its height
  const LEFT = 50, RIGHT = 8, TOP = 8, BOTTOM = 36;
  const TICKS = 5; // about so many an axis

  // x and y stand side by side.
  const PAIR = `${window.llsrbm.layout.boxOf("llsrbm-atlas")} > :is(:nth-child(4), :nth-child(5))`;

  const STYLE = `
    ${PLACE} { padding: 0 10px; font-size: 13px; line-height: 1.4; }
    ${PLACE} svg { display: block; width: 100%; border-radius: 4px; cursor: pointer;
      font: 12px system-ui, sans-serif; }
    ${PLACE} svg:focus-visible { outline: 2px solid var(--mantine-primary-color-filled);
      outline-offset: 1px; }
    ${PLACE} text { fill: currentColor; }
    ${PLACE} .cell { shape-rendering: crispEdges; }
    ${PLACE} .frame { fill: none; stroke: currentColor; stroke-opacity: 0.5; }
    ${PLACE} .halo { fill: none; stroke: #fff; stroke-width: 4; stroke-linejoin: round; }
    ${PLACE} .border { fill: none; stroke: #000; stroke-width: 1.8; stroke-linejoin: round; }
    ${PLACE} .chosen { fill: none; stroke: var(--mantine-primary-color-filled); stroke-width: 2.5;
      pointer-events: none; }
    ${PLACE} .mark { pointer-events: none; }
    ${PLACE} .described { min-height: 4.2em; margin: 2px 0 4px; }
    ${PLACE} .legend { display: flex; flex-wrap: wrap; gap: 1px 12px; align-items: center;
      margin-bottom: 8px; }
    ${PLACE} .key { white-space: nowrap; }
    ${PLACE} .key > svg { display: inline-block; width: 18px; height: 12px; margin-right: 5px;
      vertical-align: -2px; cursor: default; border-radius: 2px; }
    ${PLACE} .bar { display: inline-block; width: 90px; height: 10px; margin: 0 5px;
      vertical-align: -1px; border-radius: 2px; }
    ${PAIR} { display: inline-block; width: 50%; vertical-align: top; }
    ${PAIR} .mantine-Flex-root > div:first-child { width: 1.6rem !important; }
    ${PLACE} .larger { font: inherit; padding: 2px 8px; cursor: pointer; color: inherit;
      background: var(--mantine-color-default); border-radius: 4px;
      border: 1px solid var(--mantine-color-default-border); }
    #llsrbm-atlas { display: none; left: 8px; right: 8px; top: 8px; bottom: 8px;
      box-sizing: border-box; overflow-y: auto; padding: 6px 4px; border-radius: 8px;
      color: var(--mantine-color-text); background: var(--mantine-color-body);
      border: 1px solid var(--mantine-color-default-border); z-index: 2; }
    #llsrbm-atlas.open { display: block; }
    #llsrbm-atlas h2 { margin: 0 10px 4px; font: 600 16px/1.6 system-ui, sans-serif; }
    #llsrbm-atlas .described { min-height: 1.4em; }
    #llsrbm-atlas .close { position: absolute; right: 8px; top: 6px; min-width: 32px;
      min-height: 30px; cursor: pointer; color: inherit; background: var(--mantine-color-default);
      border: 1px solid var(--mantine-color-default-border); border-radius: 4px; }
    ${PLACE} .slice { color: var(--mantine-color-dimmed); }`;

  let map = null, mark = null, chosen = -1; // chosen: number of a cell
  let version = 0, requested = -Infinity;
  let drawn = null; // the place in which the map of this version is
  let [wide, high] = IN_PANEL; // of the map that is drawn

  // ---- the drawer

  const large = element("div", { class: "llsrbm-atlas" });
  const drawer = element("section", {
    id: "llsrbm-atlas", "aria-label": "Atlas", onkeydown: (event) => event.key === "Escape" && fold(),
  }, element("h2", {}, "Atlas"), large, element("button",
    { type: "button", class: "close", "aria-label": "Close the atlas", onclick: fold }, "✕"));
  layout.over.append(drawer);

  function unfold() {
    drawer.classList.add("open");
    look();
    drawer.querySelector("svg")?.focus();
  }

  function fold() {
    if (!drawer.classList.contains("open")) return;
    drawer.classList.remove("open");
    look();
    document.querySelector(`${PLACE} .larger`)?.focus();
  }

  // ---- places

  const across = (value) => LEFT + place(map.x, value) * (wide - LEFT - RIGHT);
  const up = (value) => high - BOTTOM - place(map.y, value) * (high - TOP - BOTTOM);

  function place({ edges }, value) {
    return (value - edges[0]) / (edges.at(-1) - edges[0]);
  }

  function ticks({ edges }) {
    const rough = (edges.at(-1) - edges[0]) / TICKS, power = 10 ** Math.floor(Math.log10(rough));
    const turn = [45, 90, 180].find((each) => each >= rough); // of a circle
    const step = edges.at(-1) - edges[0] > 180 && turn
      ? turn : [1, 2, 2.5, 5, 10].map((each) => each * power).find((each) => each >= rough);
    const found = [];
    for (let k = Math.ceil(edges[0] / step - 1e-9); k * step <= edges.at(-1) + 1e-9; k += 1)
      found.push(Number((k * step).toPrecision(6)));
    return found;
  }

  const columns = () => map.x.centres.length;

  function cellAt(event) {
    const matrix = event.currentTarget.getScreenCTM();
    if (!matrix) return -1;
    const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
    const column = map.x.edges.findIndex((edge, k) => k > 0 && x <= across(edge)) - 1;
    const row = map.y.edges.findIndex((edge, k) => k > 0 && y >= up(edge)) - 1;
    const inside = x >= across(map.x.edges[0]) && y <= up(map.y.edges[0]);
    return inside && row >= 0 && column >= 0 ? row * columns() + column : -1;
  }

  // ---- words

  const minus = (number) => String(number).replace("-", "−");
  const valued = ({ title, unit }, value) =>
    `${title} ${minus(Number(value.toPrecision(3)))}${unit === "deg" ? "°" : unit ? ` ${unit}` : ""}`;

  // Not as the sliders are labelled: a name in the page means one thing.
  const heading = ({ title, unit }) => unit ? `${title} (${unit})` : title;

  function words(cell) {
    if (cell < 0) return "Point at a cell to read its jump; click to open it.";
    const row = Math.floor(cell / columns()), column = cell % columns();
    const [x, y] = map.at && map.jump[cell] >= 0 ? [map.at[0][cell], map.at[1][cell]]
      : [map.x.centres[column], map.y.centres[row]];
    const where = `${valued(map.x, x)}, ${valued(map.y, y)}`;
    if (map.jump[cell] < 0) return `${where}: the sweep has no jump there.`;
    const { plannable, strict, torque, flight } = map.figures;
    const share = (values) => `${Math.round(values[cell])} %`;
    const parts = [];
    if (map.count) parts.push(`${share(plannable)} of ${map.count[cell]} jumps can be planned`);
    else parts.push(plannable[cell] > 0 ? "can be planned" : "cannot be planned");
    const stop = map.stops[map.stop[cell]];
    if (stop !== "none (feasible)") parts.push(`${map.count ? "mostly " : ""}stopped by: ${stop}`);
    if (strict?.[cell] != null) parts.push(`strict landings ${share(strict)}`);
    if (torque[cell] != null) parts.push(`largest torque share ${share(torque)}`);
    if (flight[cell] != null) parts.push(`flight ${flight[cell].toFixed(2)} s`);
    return `${where}: ${parts.join("; ")}.`;
  }

  // ---- drawing

  function choose(cell) {
    chosen = cell;
    if (!drawn) return;
    const box = drawn.querySelector(".chosen");
    const line = drawn.querySelector(".described");
    if (line.textContent !== words(cell)) line.textContent = words(cell);
    box.setAttribute("visibility", cell < 0 ? "hidden" : "visible");
    if (cell >= 0)
      for (const [name, value] of Object.entries(boxOf(cell))) box.setAttribute(name, value);
  }

  function boxOf(cell) {
    const row = Math.floor(cell / columns()), column = cell % columns();
    const x = across(map.x.edges[column]), y = up(map.y.edges[row + 1]);
    return {
      x, y, width: across(map.x.edges[column + 1]) - x, height: up(map.y.edges[row]) - y,
    };
  }

  const hatch = (id) => shape("pattern",
    { id, width: 6, height: 6, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" },
    shape("rect", { width: 6, height: 6, fill: "#8883" }),
    shape("rect", { width: 1.6, height: 6, fill: "#8889" }));

  function picture() {
    const cells = map.jump.flatMap((jump, cell) => jump < 0 ? [] : [shape("rect",
      { class: "cell", ...boxOf(cell), fill: map.fill[cell] ?? "url(#llsrbm-none)" })]);
    const paths = map.border.map((line) =>
      `M${line.map(([x, y]) => `${across(x).toFixed(1)} ${up(y).toFixed(1)}`).join("L")}`).join("");
    const low = high - BOTTOM, text = (attributes, words) => shape("text", attributes, words);
    const marks = [
      ...ticks(map.x).flatMap((value) => [
        shape("path", { class: "frame", d: `M${across(value)} ${low}v4` }),
        text({ x: across(value), y: low + 15, "text-anchor": "middle" }, minus(value)),
      ]),
      ...ticks(map.y).flatMap((value) => [
        shape("path", { class: "frame", d: `M${LEFT} ${up(value)}h-4` }),
        text({ x: LEFT - 6, y: up(value) + 4, "text-anchor": "end" }, minus(value)),
      ]),
      text({ x: (LEFT + wide - RIGHT) / 2, y: high - 6, "text-anchor": "middle" },
        heading(map.x)),
      text({
        "text-anchor": "middle", transform: `translate(10 ${(TOP + low) / 2}) rotate(-90)`,
      }, heading(map.y)),
    ];
    const made = shape("svg", {
      viewBox: `0 0 ${wide} ${high}`, tabindex: 0, role: "application",
      "aria-label": `Map of ${map.heading} over ${map.x.title} and ${map.y.title}: arrow keys ` +
        "choose a jump, Enter opens it",
    },
    shape("defs", {}, hatch("llsrbm-none")), ...cells,
    shape("path", { class: "halo", d: paths }), shape("path", { class: "border", d: paths }),
    shape("rect", {
      class: "frame", x: LEFT, y: TOP, width: wide - LEFT - RIGHT, height: low - TOP,
    }),
    ...marks, shape("rect", { class: "chosen", visibility: "hidden" }), ring("mark"));
    made.addEventListener("pointermove", (event) => choose(cellAt(event)));
    made.addEventListener("pointerleave", () => choose(-1));
    made.addEventListener("click", (event) => open(cellAt(event)));
    made.addEventListener("keydown", press);
    return made;
  }

  // The present design's ring.
  const ring = (name) => shape("g", { class: name },
    shape("circle", { r: 5.5, fill: "none", stroke: "#fff", "stroke-width": 4.5 }),
    shape("circle", { r: 5.5, fill: "none", stroke: "#28a05a", "stroke-width": 2.4 }));

  const key = (shapes, words) => element("span", { class: "key" },
    shape("svg", { viewBox: "0 0 18 12", "aria-hidden": "true" }, ...shapes), words);
  const square = (fill) => shape("rect", { width: 18, height: 12, fill });

  function legend() {
    const { keys, stops, low, high } = map.legend;
    const made = element("div", { class: "legend" });
    if (keys) made.append(`${map.heading}:`, ...keys.map(([colour, words]) => key([square(colour)], words)));
    else
      made.append(map.heading, element("span", { class: "key" }, minus(low),
        element("span", {
          class: "bar", style: `background: linear-gradient(90deg, ${stops.join()})`,
        }), minus(high)));
    if (map.jump.some((jump, cell) => jump >= 0 && map.fill[cell] === null))
      made.append(key([shape("defs", {}, hatch("llsrbm-none-key")),
        square("url(#llsrbm-none-key)")], "no plan"));
    if (map.border.length)
      made.append(key([shape("path", { class: "halo", d: "M0 6h18" }),
        shape("path", { class: "border", d: "M0 6h18" })], "border of what can be planned"));
    const design = ring("");
    design.setAttribute("transform", "translate(9 6) scale(0.8)");
    made.append(key([design], "present design"));
    return made;
  }

  function draw(target) {
    if (drawn !== target) drawn?.replaceChildren(); // one map at a time
    drawn = target;
    [wide, high] = target === large ? [large.clientWidth - AROUND[0],
      Math.max(LEAST, drawer.clientHeight - AROUND[1])] : IN_PANEL; // letters as large as elsewhere
    target.setAttribute("data-version", version);
    target.replaceChildren();
    if (!map) return;
    target.append(
      ...(map.slice ? [element("div", { class: "slice" }, minus(map.slice))] : []),
      picture(), element("div", { class: "described", "aria-live": "polite" }), legend(),
      ...(target === large ? [] : [element("button",
        { type: "button", class: "larger", onclick: unfold }, "Show it large")]),
    );
    choose(chosen < map.jump.length ? chosen : -1);
    moveMark();
  }

  function moveMark() {
    const point = drawn?.querySelector(".mark");
    if (!point || !map || !mark) return;
    const within = (value, low, high) => Math.min(Math.max(value, low), high);
    const x = within(across(mark[0]), LEFT, wide - RIGHT);
    const y = within(up(mark[1]), TOP, high - BOTTOM);
    point.setAttribute("transform", `translate(${x.toFixed(2)} ${y.toFixed(2)})`);
  }

  function look() {
    const open = drawer.classList.contains("open");
    const target = open ? large : document.querySelector(`${PLACE}:not(#llsrbm-atlas *)`);
    if (!target?.getClientRects().length) return void (drawn = null); // or its folder is closed
    if (!version && performance.now() - requested > REQUEST_EVERY) {
      requested = performance.now();
      page.send({ kind: "atlas-seen" });
      setTimeout(layout.soon, REQUEST_EVERY);
    }
    const old = target !== drawn || target.getAttribute("data-version") !== String(version);
    if (version && old) draw(target);
  }

  // ---- acts

  function open(cell) {
    if (cell < 0 || map.jump[cell] < 0) return;
    page.send({ kind: "atlas", sweep: map.sweep, jump: map.jump[cell] });
    fold();
  }

  function press(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const rows = map.y.centres.length, many = columns();
    const steps = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [1, 0], ArrowDown: [-1, 0] };
    const step = steps[event.key];
    if (event.key === "Enter" || event.key === " ") open(chosen);
    else if (step && chosen < 0) choose(nearest());
    else if (step) {
      const row = Math.floor(chosen / many) + step[0], column = (chosen % many) + step[1];
      if (row >= 0 && row < rows && column >= 0 && column < many) choose(row * many + column);
    } else return;
    event.preventDefault();
    event.stopPropagation();
  }

  // The cell of the present design.
  function nearest() {
    const best = ({ centres }, value) => centres.reduce(
      (found, centre, k) => Math.abs(centre - value) < Math.abs(centres[found] - value) ? k : found,
      0);
    return mark ? best(map.y, mark[1]) * columns() + best(map.x, mark[0]) : 0;
  }

  addToPage(STYLE);
  layout.onChange(look);

  window.llsrbm.atlas = {
    show(sent) {
      const same = map && sent && map.x.title === sent.x.title && map.y.title === sent.y.title &&
        map.jump.length === sent.jump.length;
      if (!same) chosen = -1;
      map = sent;
      version += 1;
      look();
    },
    mark(x, y) {
      mark = [x, y];
      moveMark();
    },
    forget() {
      map = mark = null;
      version = 0;
      requested = -Infinity;
    },
    get map() { return map; },
    get described() { return drawn?.querySelector(".described")?.textContent ?? ""; },
  };
})();
