// A chart as a figure for a paper: SVG as wide as a column, on white, and PNG of it. Made from what
// the chart shows, with its zoom. window.llsrbm.plotFigure.buttons(chart): two buttons that copy it to
// the clipboard; where a page may not, it is saved as a file.
(() => {
  const { element, shape, save } = window.llsrbm;
  const WIDTH = 88, HEIGHT = 56; // mm, of a column of two
  const POINTS = 72 / 25.4, DPI = 600; // a mm; of the PNG
  const LEFT = 32, RIGHT = 10, TOP = 14, UNDER = 24, LINE = 9; // points around the curves; of text
  const SIZE = 7, LETTER = 0.52; // points of the letters; their width, as a share of it
  const TICKS = [6, 5]; // at most about, along and up
  const SAID = 1500; // ms for which a button says what it has done
  const INK = "#1a1a1a", GRID = "#e3e3e3", SHADE = "#ededed";

  // Even numbers between two values, and how they are written.
  function ticks(low, high, count) {
    const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].find((each) => each * power >= rough) * power;
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    const first = Math.ceil(low / step - 1e-9);
    return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, i) => {
      const value = (first + i) * step, text = value.toFixed(digits);
      return { value, text: (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "−") };
    });
  }

  // Instants at which a series of marks rises or falls.
  function steps(time, values, rises) {
    return time.filter((_, i) => i && (values[i] > 0) !== (values[i - 1] > 0)
      && values[i] > 0 === rises);
  }

  function svgOf(chart) {
    const [width, height] = [WIDTH * POINTS, HEIGHT * POINTS], time = [...chart.data[0]];
    const { x: { min: from, max: to }, y: { min: low, max: high } } = chart.scales;
    const { linesOf, titleOf } = window.llsrbm.plots;
    const curves = linesOf(chart, "curve").filter(({ index }) => chart.data[index].some(Number.isFinite));
    const keys = legend(curves, width);
    const top = TOP + keys.height, bottom = height - UNDER;
    const x = (value) => LEFT + ((value - from) / (to - from)) * (width - LEFT - RIGHT);
    const y = (value) => bottom - ((value - low) / (high - low)) * (bottom - top);
    const text = (at, up, words, anchor = "middle") =>
      shape("text", { x: at.toFixed(2), y: up.toFixed(2), "text-anchor": anchor }, words);
    const line = (path, attributes) => shape("path", { d: path, fill: "none", ...attributes });
    const inside = shape("g", { "clip-path": "url(#area)" });
    const svg = shape("svg", { width: `${WIDTH}mm`, height: `${HEIGHT}mm`,
      viewBox: `0 0 ${width.toFixed(2)} ${height.toFixed(2)}`, "font-size": SIZE, fill: INK,
      "font-family": "Helvetica, Arial, sans-serif" },
      shape("clipPath", { id: "area" }, shape("rect",
        { x: LEFT, y: top, width: width - LEFT - RIGHT, height: bottom - top })),
      shape("rect", { width, height, fill: "#fff" }), text(LEFT, LINE, titleOf(chart), "start"), keys.drawn);
    const flight = chart.data[1], lifts = steps(time, flight, true), lands = steps(time, flight, false);
    if (flight[0] > 0) lifts.unshift(from);
    lifts.forEach((start, i) => inside.append(shape("rect", { x: x(start), y: top, fill: SHADE,
      width: Math.max(0, x(lands[i] ?? to) - x(start)), height: bottom - top })));
    for (const { value, text: words } of ticks(from, to, TICKS[0])) {
      inside.append(line(`M${x(value).toFixed(2)} ${top}V${bottom}`,
        { stroke: GRID, "stroke-width": 0.4 }));
      svg.append(text(x(value), bottom + LINE, words));
    }
    for (const { value, text: words } of ticks(low, high, TICKS[1])) {
      inside.append(line(`M${LEFT} ${y(value).toFixed(2)}H${width - RIGHT}`,
        { stroke: GRID, "stroke-width": 0.4 }));
      svg.append(text(LEFT - 3, y(value) + 2.4, words, "end"));
    }
    for (const mark of linesOf(chart, "mark"))
      for (const instant of steps(time, chart.data[mark.index], true))
        inside.append(line(`M${x(instant).toFixed(2)} ${top}V${bottom}`, drawnAs(mark, 0.7)));
    for (const curve of curves)
      inside.append(line(path(time, chart.data[curve.index], x, y), drawnAs(curve, 1)));
    svg.append(inside, line(`M${LEFT} ${top}V${bottom}H${width - RIGHT}`,
      { stroke: INK, "stroke-width": 0.6 }),
      text((LEFT + width - RIGHT) / 2, bottom + 2 * LINE + 2, "time [s]"));
    return new XMLSerializer().serializeToString(svg);
  }

  function drawnAs({ colour, dash }, width) {
    return { stroke: colour, "stroke-width": width, "stroke-linejoin": "round",
      ...(dash?.length ? { "stroke-dasharray": dash.map((part) => 0.75 * part).join(" ") } : {}) };
  }

  function path(time, values, x, y) {
    let words = "", drawn = false;
    for (let i = 0; i < time.length; i++) {
      const there = Number.isFinite(values[i]);
      if (there) words += `${drawn ? "L" : "M"}${x(time[i]).toFixed(2)} ${y(values[i]).toFixed(2)}`;
      drawn = there;
    }
    return words;
  }

  // Samples of the lines with their names, in as many rows as they need.
  function legend(curves, width) {
    const drawn = shape("g", {}), sample = 16, gap = 8;
    let at = LEFT, row = 0;
    for (const curve of curves) {
      const long = sample + 3 + SIZE * LETTER * curve.name.length;
      if (at > LEFT && at + long > width - RIGHT) [at, row] = [LEFT, row + 1];
      const up = TOP + LINE * row + 4;
      drawn.append(shape("path", { d: `M${at} ${up}h${sample}`, fill: "none",
        ...drawnAs(curve, 1) }),
        shape("text", { x: at + sample + 3, y: up + 2.4 }, curve.name));
      at += long + gap;
    }
    return { drawn, height: curves.length ? LINE * (row + 1) + 3 : 0 };
  }

  function pngOf(svg) {
    const image = new Image(), canvas = document.createElement("canvas");
    canvas.width = Math.round((WIDTH / 25.4) * DPI);
    canvas.height = Math.round((HEIGHT / 25.4) * DPI);
    image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svg)}`;
    return image.decode().then(() => {
      canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
      return new Promise((done) => canvas.toBlob(done, "image/png"));
    });
  }

  async function copy(chart, kind) {
    const svg = svgOf(chart);
    const blob = kind === "svg" ? new Blob([svg], { type: "image/svg+xml" }) : await pngOf(svg);
    try {
      const item = kind === "svg"
        ? { "text/plain": new Blob([svg], { type: "text/plain" }),
          ...(ClipboardItem.supports?.(blob.type) ? { [blob.type]: blob } : {}) }
        : { [blob.type]: blob };
      await navigator.clipboard.write([new ClipboardItem(item)]);
      return "copied";
    } catch { // not allowed, or not over https
      save(blob, `chart.${kind}`);
      return "saved";
    }
  }

  window.llsrbm.plotFigure = {
    svgOf, pngOf,
    buttons: (chart) => ["svg", "png"].map((kind) => {
      const name = kind.toUpperCase(), label = `Copy as ${name}`;
      const made = element("button", { type: "button", "aria-label": label,
        title: `${label}, ${WIDTH} mm wide for a paper's column` }, name);
      made.addEventListener("click", async (event) => {
        event.stopPropagation();
        made.textContent = await copy(chart, kind);
        setTimeout(() => (made.textContent = name), SAID);
      });
      return made;
    }),
  };
})();
