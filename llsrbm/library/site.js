// The list of a library's site (site.py): filters, and a card a motion with a sketch of the CoM's way.
(() => {
  const rows = JSON.parse(document.getElementById("rows").textContent);
  const form = document.getElementById("filters");
  const list = document.getElementById("motions");
  const SVG = Object.assign(document.createElement("template"), { innerHTML: "<svg></svg>" })
    .content.firstChild.namespaceURI;
  const degrees = (angle) => Math.round(angle * 180 / Math.PI);

  const NUMBERS = [ // name, label, step, whether a row passes
    ["distance", "Leads at least [m]", 0.05, (row, least) => row.distance >= least],
    ["turn", "Turns at least [deg]", 15, (row, least) => Math.abs(degrees(row.turn)) >= least],
    ["height", "Lands at least so high [m]", 0.05, (row, least) => row.height >= least],
    ["flight", "In the air at least [s]", 0.05, (row, least) => row.flight >= least],
  ];

  function labelled(text, control) {
    const label = document.createElement("label");
    label.append(text, control);
    form.append(label);
    return control;
  }

  function choice(name, text) {
    const select = labelled(text, document.createElement("select"));
    select.add(new Option("all", ""));
    for (const value of [...new Set(rows.map((row) => row[name]))].sort()) select.add(new Option(value, value));
    return (row) => !select.value || row[name] === select.value;
  }

  const word = labelled("Words", document.createElement("input"));
  word.type = "search";
  const tests = [
    (row) => word.value.toLowerCase().split(/\s+/).every(
      (part) => `${row.name} ${row.robot} ${row.kind}`.toLowerCase().includes(part)),
    choice("robot", "Robot"),
    choice("kind", "Kind"),
    ...NUMBERS.map(([name, text, step, passes]) => {
      const input = labelled(text, document.createElement("input"));
      Object.assign(input, { type: "number", step, name });
      return (row) => input.value === "" || passes(row, input.valueAsNumber);
    }),
  ];

  function sketch(path) {
    const svg = document.createElementNS(SVG, "svg");
    const line = document.createElementNS(SVG, "polyline");
    const [x, y] = [0, 1].map((axis) => path.map((point) => point[axis]));
    const low = [Math.min(...x), Math.min(...y)];
    const size = Math.max(Math.max(...x) - low[0], 2 * (Math.max(...y) - low[1]), 0.2);
    svg.setAttribute("viewBox", "-3 -3 106 56");
    svg.setAttribute("aria-hidden", "true");
    line.setAttribute("points", path.map((point) =>
      `${100 * (point[0] - low[0]) / size},${50 - 100 * (point[1] - low[1]) / size}`).join(" "));
    for (const [name, value] of Object.entries({ fill: "none", stroke: "#5a3cb4", "stroke-width": 2 }))
      line.setAttribute(name, value);
    svg.append(line);
    return svg;
  }

  function card(row) {
    const link = document.createElement("a");
    const name = document.createElement("strong"), words = document.createElement("small");
    link.href = `motions/${row.name}.html`;
    name.textContent = `${row.robot}: ${row.kind.replaceAll("-", " ")}`;
    words.textContent = `${row.distance.toFixed(2)} m, ${degrees(row.turn)}°, up ${row.height.toFixed(2)} m, ` +
      `${row.flight.toFixed(2)} s in the air, ${row.power} W, ${row.strict.join(" of ")} strict`;
    const title = document.createElement("small");
    title.textContent = row.name;
    link.append(name, title, words, sketch(row.path));
    return link;
  }

  function show() {
    const kept = rows.filter((row) => tests.every((passes) => passes(row)));
    document.getElementById("count").textContent = `${kept.length} of ${rows.length}`;
    list.replaceChildren(...kept.map(card));
  }

  form.addEventListener("input", show);
  form.addEventListener("submit", (event) => event.preventDefault());
  show();
})();
