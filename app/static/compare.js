// A card on top of the bar below the picture: a jump made in several ways, side by side. While they are
// tried it says how far they are; then one sentence on who turned how far, and a table of figures. The
// same card is that of a motion of another tool: which checks it breaks, and its repair beside it.
(() => {
  const { page, element, swatch, write, addToPage } = window.llsrbm;
  const COMPARES = "data-llsrbm-compares"; // of the page, while the card is there
  const HIGH = 1000; // pixels of a window from which on the table is open at first

  const STYLE = `
    #llsrbm-compare { position: relative; max-height: 30vh; overflow-y: auto; padding: 2px 34px 6px 2px; margin-bottom: 6px;
      font: 13px/1.45 system-ui, sans-serif; user-select: text;
      border-bottom: 1px solid var(--mantine-color-default-border); }
    #llsrbm-compare .ways { display: flex; flex-wrap: wrap; gap: 2px 14px; margin: 0; padding: 0;
      list-style: none; align-items: center; }
    #llsrbm-compare .ways > li { display: flex; gap: 6px; align-items: center; font-weight: 600; }
    #llsrbm-compare .ways > .waits { opacity: 0.55; font-weight: 400; }
    #llsrbm-compare i { width: 10px; height: 10px; border-radius: 3px; flex: none; }
    #llsrbm-compare .busy > i { animation: llsrbm-busy 0.7s infinite alternate; }
    @keyframes llsrbm-busy { to { opacity: 0.2; } }
    #llsrbm-compare p { margin: 2px 0 0; max-width: 68rem; }
    #llsrbm-compare summary { cursor: pointer; width: max-content; }
    #llsrbm-compare table { border-spacing: 0; font-variant-numeric: tabular-nums; }
    #llsrbm-compare :is(th, td) { text-align: right; padding: 0 0 0 1.2em; font-weight: 400; }
    #llsrbm-compare thead th { font-weight: 600; }
    #llsrbm-compare tbody th { text-align: left; padding-left: 0; }
    #llsrbm-compare .repair { font: inherit; font-weight: 600; min-height: 26px; padding: 1px 12px;
      border-radius: 4px; cursor: pointer; color: var(--mantine-color-text);
      background: var(--mantine-primary-color-light); border: 1px solid var(--mantine-primary-color-filled); }
    #llsrbm-compare .repair:disabled { opacity: 0.5; cursor: default; }
    #llsrbm-compare .close { position: absolute; top: 0; right: 0; min-width: 28px; min-height: 26px; }
    @media (prefers-reduced-motion: reduce) { #llsrbm-compare .busy > i { animation: none; } }
    /* On a phone the robots side by side are what there is to see. */
    @media (max-width: 640px) {
      #llsrbm-compare { max-height: 17vh; }
      #llsrbm-compare.of-file { max-height: 22vh; }
      [${COMPARES}] [data-llsrbm-sheet] { max-height: 24vh !important; } }`;

  const close = () => page.send({ kind: "comparison-closed" });
  let last = ""; // what is shown but for the progress, which comes many times a second
  let open = null; // whether the table is, once it was opened or closed by hand

  const way = ({ name, colour, state }) =>
    element("li", { class: state }, swatch(colour), name);

  function figures(ways, rows) {
    const head = element("tr", {}, element("td"),
      ...ways.map(({ name }) => element("th", { scope: "col" }, name)));
    const body = rows.map(({ title, values }) => element("tr", {},
      element("th", { scope: "row" }, title), ...values.map((text) => element("td", {}, text))));
    const table = element("details", {}, element("summary", {}, "Figures"),
      element("table", {}, element("thead", {}, head), element("tbody", {}, ...body)));
    table.open = open ?? innerHeight >= HIGH;
    table.addEventListener("toggle", () => (open = table.open));
    return table;
  }

  // "ready", "waits": whether a press has the motion repaired; "": there is nothing to repair.
  const repairing = (repair) => {
    const button = element("button", { type: "button", class: "repair",
      title: "Find the nearest motion whose checks hold, and make it the plan",
      onclick: () => page.send({ kind: "repair" }) }, "Repair");
    button.disabled = repair !== "ready";
    return element("li", {}, button);
  };

  const card = element("section", { id: "llsrbm-compare", "aria-label": "Comparison" });
  card.style.display = "none";
  addToPage(STYLE);
  document.addEventListener("DOMContentLoaded", () =>
    document.getElementById("llsrbm-transport").prepend(card));
  window.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && card.contains(document.activeElement)) close();
  });

  window.llsrbm.compare = {
    // null: nothing is compared (app/tab/contenders.py and foreign.py, `card`).
    show(comparison) {
      card.style.display = comparison ? "" : "none";
      document.documentElement.toggleAttribute(COMPARES, Boolean(comparison));
      const { note, ...others } = comparison ?? {}, before = last;
      last = comparison ? JSON.stringify(others) : "";
      if (!comparison) return card.replaceChildren();
      if (last === before) return write(card.querySelector("p"), others.sentence || note);
      const { ways, sentence, rows, repair } = others;
      card.classList.toggle("of-file", repair !== undefined);
      card.replaceChildren(
        element("ul", { class: "ways", "aria-label": "Compared, from left to right" },
          ...ways.map(way), ...(repair ? [repairing(repair)] : [])),
        element("p", { "aria-live": "polite" },
          sentence || note),
        ...(rows.length ? [figures(ways, rows)] : []),
        element("button", { type: "button", class: "close", title: "Close the comparison",
          "aria-label": "Close the comparison", onclick: close }, "✕"));
    },
  };
})();
