// The table of weights and limits (app/panel/tuning.py): its numbers come from the server, what
// is typed goes there. The rows say their group, name and default themselves.
(() => {
  const { page, layout } = window.llsrbm;
  const TABLE = ".llsrbm-tuning", ROW = "tr[data-name]", RESET = "button[data-reset]";
  const FILLED = "data-filled"; // with which numbers

  let values = { weights: {}, limits: {} }, version = 0;

  const numberIn = (row) => row.querySelector("input");
  const defaultOf = (row) => Number(row.dataset.default);

  function mark(row) {
    row.classList.toggle("changed", Number(numberIn(row).value) !== defaultOf(row));
  }

  function fill(anew = false) {
    for (const table of document.querySelectorAll(TABLE)) {
      if (!anew && table.getAttribute(FILLED) === String(version)) continue;
      table.setAttribute(FILLED, version);
      for (const row of table.querySelectorAll(ROW)) {
        const { group, name } = row.dataset;
        numberIn(row).value = values[group][name] ?? defaultOf(row);
        mark(row);
      }
    }
  }

  function choose(row, text) {
    const number = text.trim() === "" ? null : Number(text);
    const value = number === null || !Number.isFinite(number) || number === defaultOf(row)
      ? null : number;
    if (value === null) numberIn(row).value = defaultOf(row);
    mark(row);
    page.send({ kind: "tuning", group: row.dataset.group, name: row.dataset.name, value });
  }

  const rowOf = (event, selector) =>
    event.target instanceof Element && event.target.closest(TABLE) && event.target.closest(selector)
      ? event.target.closest(ROW) : null;

  document.addEventListener("change", (event) => {
    const row = rowOf(event, "input");
    if (row) choose(row, event.target.value);
  });
  document.addEventListener("click", (event) => {
    const row = rowOf(event, RESET);
    if (!row) return;
    choose(row, "");
    numberIn(row).focus();
  });
  // viser makes the table anew whenever its tab is opened; what is typed right after that must not be
  // overwritten by the next look.
  document.addEventListener("focusin", (event) => { if (rowOf(event, "input")) fill(); });
  layout.onChange(() => fill());

  window.llsrbm.tuning = {
    show(changed) {
      values = changed;
      version += 1;
      fill(true);
    },
  };
})();
