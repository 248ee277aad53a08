// The list of a library's site (site.py): filters, and a card a motion with a stick figure that moves.
(() => {
  const rows = JSON.parse(document.getElementById("rows").textContent);
  const form = document.getElementById("filters");
  const list = document.getElementById("motions");
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

  function card(row) {
    const link = document.createElement("a");
    const name = document.createElement("strong"), words = document.createElement("small");
    link.href = `motions/${row.name}.html`;
    name.textContent = `${row.robot}: ${row.kind.replaceAll("-", " ")}`;
    words.textContent = `${row.distance.toFixed(2)} m, ${degrees(row.turn)}°, up ${row.height.toFixed(2)} m, ` +
      `${row.flight.toFixed(2)} s in the air, ${row.power} W, ${row.strict.join(" of ")} strict`;
    const title = document.createElement("small");
    title.textContent = row.name;
    link.append(name, title, words);
    if (row.figure) link.append(window.llsrbm.stickFigure(row.figure));
    return link;
  }

  const cards = new Map(rows.map((row) => [row, card(row)]));

  function show() {
    const kept = rows.filter((row) => tests.every((passes) => passes(row)));
    document.getElementById("count").textContent = `${kept.length} of ${rows.length}`;
    list.replaceChildren(...kept.map((row) => cards.get(row)));
  }

  form.addEventListener("input", show);
  form.addEventListener("submit", (event) => event.preventDefault());
  show();
})();
