// How the panel looks: its rows in a grid, one filled button, labels that do not wrap, readable greys.
// viser draws the controls; this script only adds style sheets. `arrange` learns from the server
// which control is which; markers in the panel's own HTML (app/panel) say where the rest belongs.
(() => {
  const MAIN = "div:has(> div > .llsrbm-status)"; // the box with the controls that are always there
  const BOXES = "div:has(> div > .llsrbm-boxes)"; // a box of checkboxes
  const PAIRS = "div:has(> div > .llsrbm-pair)"; // a box whose buttons stand side by side
  const FIELD = ".mantine-Flex-root > div:first-child"; // the place of a label

  const FILLED = "rgb(38 92 150)"; // the brand's, dark enough for white letters

  const STYLE = `
    :root[data-mantine-color-scheme=light] { --mantine-color-dimmed: #59616a !important; }
    :root[data-mantine-color-scheme=dark] { --mantine-color-dimmed: #b4bac2 !important; }

    ${MAIN} { display: grid; grid-template-columns: repeat(12, minmax(0, 1fr)); column-gap: 6px;
      grid-auto-flow: dense; padding: 0 10px; } /* rows of buttons stay rows, whatever lies between */
    ${MAIN} > * { grid-column: 1 / -1; min-width: 0; margin-inline: 0 !important;
      padding-inline: 0 !important; }
    ${MAIN} > div > ${FIELD}, ${MAIN} > div > div > ${FIELD} { width: 7.6rem !important;
      padding-right: 6px; }
    ${MAIN} label, ${BOXES} label, ${PAIRS} label { white-space: nowrap; font-size: 0.8rem;
      letter-spacing: -0.4px; }
    ${MAIN} .mantine-Slider-root { margin-right: 2px; }

    /* Every button is quiet but the one that is there to be pressed. */
    .mantine-Button-root[data-block], .mantine-Button-root[data-variant=outline] {
      background: var(--mantine-color-default); color: var(--mantine-color-text);
      border: 1px solid var(--mantine-color-default-border); font-size: 0.8rem; }
    .mantine-Button-root[data-block]:not([data-disabled]):hover {
      background: var(--mantine-color-default-hover); color: var(--mantine-color-text); }
    .mantine-Button-root[data-block][data-disabled] { background: transparent;
      color: var(--mantine-color-dimmed); opacity: 0.6; }
    .mantine-Button-root[data-block] { padding-inline: 0.5rem; }

    [data-dock-area^=gui-tabs] [role=tablist] { display: flex; flex-wrap: nowrap !important; }
    [data-dock-area^=gui-tabs] [role=tab] { flex: 1 1 auto !important; min-width: 0;
      justify-content: center; padding-inline: 3px !important; font-size: 0.74rem !important;
      letter-spacing: -0.3px; }
    [data-dock-area^=gui-tabs] [role=tab][aria-selected=true] {
      color: var(--mantine-color-text) !important; }

    ${BOXES} { display: grid; grid-template-columns: 1fr 1fr; column-gap: 4px; padding: 0 8px; }
    ${BOXES} > * { padding-inline: 0 !important; margin-inline: 0 !important;
      padding-bottom: 0.3em !important; min-width: 0; }
    ${BOXES} > :has(.llsrbm-boxes, .llsrbm-wide) { grid-column: 1 / -1; }
    ${BOXES} .mantine-Flex-root { flex-direction: row-reverse; justify-content: flex-end; gap: 6px; }
    ${BOXES} ${FIELD} { width: auto !important; padding-right: 0; flex-shrink: 1 !important; }
    ${BOXES} .mantine-Flex-root > div:last-child { flex-grow: 0 !important; }

    ${PAIRS} { display: grid; grid-template-columns: 1fr 1fr; column-gap: 6px; }
    ${PAIRS} > * { grid-column: 1 / -1; min-width: 0; }
    ${PAIRS} > :has(> .mantine-Button-root) { grid-column: auto; }

    .llsrbm-progress { height: 3px; border-radius: 2px; overflow: hidden; margin: 0 0 4px; }
    .llsrbm-progress > div { height: 100%; background: var(--mantine-primary-color-filled); }
    .llsrbm-seeds { display: grid; grid-template-columns: repeat(5, 1fr); gap: 3px; margin-top: 4px;
      font-variant-numeric: tabular-nums; list-style: none; padding: 0; }
    .llsrbm-seeds > li { border: 1px solid var(--mantine-color-default-border); border-radius: 3px;
      padding: 0 4px; white-space: nowrap; }
    .llsrbm-seeds > .fell { border-color: #d6336c; background: #d6336c22; }
    .llsrbm-seeds > .worst { outline: 2px solid currentColor; font-weight: bold; }

    .llsrbm-tuning { padding: 0 10px; font-size: 0.76rem; }
    .llsrbm-tuning table { border-spacing: 0; width: 100%; margin-bottom: 0.6em; }
    .llsrbm-tuning caption { text-align: left; font-weight: bold; padding: 0.2em 0; }
    .llsrbm-tuning th { text-align: left; font-weight: normal; white-space: nowrap; padding: 1px 0; }
    .llsrbm-tuning thead th { color: var(--mantine-color-dimmed); }
    .llsrbm-tuning td { white-space: nowrap; padding: 1px 0 1px 5px; }
    .llsrbm-tuning tbody th { cursor: help; letter-spacing: -0.3px; }
    .llsrbm-tuning .number { text-align: right; font-variant-numeric: tabular-nums; }
    .llsrbm-tuning input { width: 4.6em; font: inherit; text-align: right; padding: 1px 4px;
      color: inherit; background: var(--mantine-color-default); border-radius: 3px;
      border: 1px solid var(--mantine-color-default-border); appearance: textfield; }
    .llsrbm-tuning input::-webkit-inner-spin-button { appearance: none; margin: 0; }
    .llsrbm-tuning tr.changed th, .llsrbm-tuning tr.changed input { font-weight: bold;
      color: var(--llsrbm-changed); }
    .llsrbm-tuning tr.changed input { border-color: var(--llsrbm-changed); }
    .llsrbm-tuning button { font: inherit; width: 1.6em; padding: 0; cursor: pointer; color: inherit;
      background: none; border: 1px solid var(--mantine-color-default-border); border-radius: 3px; }
    .llsrbm-tuning tr:not(.changed) button { visibility: hidden; }
    :root { --llsrbm-changed: #b04a00; }
    :root[data-mantine-color-scheme=dark] { --llsrbm-changed: #ffb366; }

    :is(button, input, select, [role=tab], [role=button], [role=slider]):focus-visible {
      outline: 2px solid var(--mantine-primary-color-filled) !important; outline-offset: 1px; }`;

  const row = (uuid) => `${MAIN} > :has([id$="${uuid}"])`;
  const button = (uuid) => `.mantine-Button-root[id="${uuid}"]`;

  // `quarters`: four in a row; `main`: to be pressed; `cancel` beside it, while there is something to
  // cancel; `format` and `save` in a row.
  function arrangement({ quarters, main, cancel, format, save }) {
    return `
      ${quarters.map(row).join()} { grid-column: span 3; }
      ${row(cancel)} { grid-column: span 4; }
      ${MAIN}:has([id="${cancel}"]) > :has([id$="${main}"]) { grid-column: span 8; }
      ${row(format)} { grid-column: span 8; }
      ${row(format)} > .mantine-Flex-root > div:first-child,
      ${row(format)} > div > .mantine-Flex-root > div:first-child { width: 4.2rem !important; }
      ${row(save)} { grid-column: span 4; }
      ${button(main)}, ${button(main)}:not([data-disabled]):hover {
        background: ${FILLED}; color: #fff; border-color: transparent; }
      ${button(main)}[data-disabled] { opacity: 0.5; }`;
  }

  const arranged = window.llsrbm.element("style");
  window.llsrbm.addToPage(STYLE, arranged);

  window.llsrbm.panel = {
    arrange: (controls) => (arranged.textContent = arrangement(controls)),
  };
})();
