// How the panel looks: its rows in a grid, of which only the tabs scroll, one filled button, labels
// that do not wrap, readable greys. viser draws the controls; this script only adds style sheets.
// `arrange` learns from the server which control is which; markers in the panel's own HTML
// (app/panel) say where the rest belongs.
(() => {
  const MAIN = "div:has(> div > .llsrbm-status)"; // the box with the controls that are always there
  const BOXES = "div:has(> div > .llsrbm-boxes)"; // a box of checkboxes
  const FOLDER = ".mantine-Paper-root:has(> .mantine-Paper-root:first-child > svg.tabler-icon)";
  const SCENARIO = "div:has(> div > .llsrbm-scenario)"; // the box of what a simulation meets
  const PAIRS = "div:has(> div > .llsrbm-pair)"; // a box whose buttons stand side by side
  const FIELD = ".mantine-Flex-root > div:first-child"; // the place of a label

  const ROWS = 50; // above the tabs, at most; those that are not there have no height
  const VERDICT = "5.4rem"; // height of the verdict: a large word, and three lines
  const ABOVE = "35rem"; // of the panel, what is not the scenario's: the tabs stay in sight

  const FILLED = "rgb(62 78 99)"; // the brand's, dark enough for white letters

  const STYLE = `
    :root[data-mantine-color-scheme=light] { --mantine-color-dimmed: #59616a !important; }
    :root[data-mantine-color-scheme=dark] { --mantine-color-dimmed: #b4bac2 !important; }

    /* Beside the picture it is as high as the page, and what is left of that is the tabs'. */
    [data-dock-region] .mantine-ScrollArea-viewport:has(> div .llsrbm-status) {
      container-type: size; }
    ${MAIN} { display: grid; grid-template-columns: repeat(20, minmax(0, 1fr)); column-gap: 4px;
      grid-template-rows: repeat(${ROWS}, auto) minmax(8rem, 1fr); box-sizing: border-box;
      height: 100cqh; align-content: start; padding: 0.4em 10px 0 !important; }
    ${MAIN} > * { grid-column: 1 / -1; min-width: 0; margin-inline: 0 !important;
      padding-inline: 0 !important; }
    ${MAIN} > div > ${FIELD}, ${MAIN} > div > div > ${FIELD} { width: 7.6rem !important;
      padding-right: 6px; }
    ${MAIN} label { white-space: nowrap; font-size: 0.8rem; letter-spacing: -0.4px; }
    ${MAIN} .mantine-Slider-root { margin-right: 2px; }

    ${MAIN} > :has(> [data-dock-area^=gui-tabs]), ${MAIN} > .mantine-Tabs-root {
      grid-row: ${ROWS + 1}; min-height: 0; margin-top: 0 !important; }
    [data-dock-region] ${MAIN} > :has(> [data-dock-area]) :is([data-dock-area], [data-dock-group],
      [role=tablist] + div, [role=tablist] + div :has(.mantine-ScrollArea-viewport)) {
      display: flex; flex-direction: column; flex: 1 1 0; height: 100%; min-height: 0; }
    [data-dock-region] ${MAIN} [data-dock-area^=gui-tabs] .mantine-ScrollArea-viewport {
      flex: 1 1 0; min-height: 0; max-height: none !important; }

    /* A tab has no scroll bar to the side. */
    ${MAIN} [data-dock-area^=gui-tabs] .mantine-ScrollArea-viewport > div {
      display: block !important; overflow-x: clip; }

    /* A folder: a line with its title, which is a button (accessibility.js), and what it holds. */
    ${FOLDER} { border-width: 1px 0 0; border-radius: 0; margin: 0 0 4px !important; }
    ${FOLDER} > .mantine-Paper-root { position: static; transform: none; padding: 3px 0;
      display: flex; align-items: center; justify-content: space-between; font-size: 0.84rem; }
    ${FOLDER} > :last-child { display: none; }
    ${SCENARIO} { padding: 0 !important; display: grid; grid-template-columns: 1fr 1fr; column-gap: 10px;
      align-items: center; max-height: clamp(10rem, 100cqh - ${ABOVE}, 34vh); overflow: auto; }
    ${SCENARIO} > * { min-width: 0; padding: 0 0 5px !important; margin-inline: 0 !important; }
    ${SCENARIO} > :has(.mantine-Slider-root, .llsrbm-wide, .mantine-Button-root) {
      grid-column: 1 / -1; }
    ${SCENARIO} ${FIELD} { width: auto !important; flex: 1 1 auto !important; padding-right: 4px; }
    ${SCENARIO} .mantine-NumberInput-root { width: 4.4rem; }
    ${SCENARIO} .mantine-Slider-root { width: 8rem; }

    ${BOXES} > *, ${SCENARIO} > * { padding-inline: 0 !important; margin-inline: 0 !important; }
    :is(${BOXES}, ${SCENARIO}) .mantine-Flex-root:has([type=checkbox]) {
      flex-direction: row-reverse; justify-content: flex-end; gap: 6px; }
    :is(${BOXES}, ${SCENARIO}) .mantine-Flex-root:has([type=checkbox]) > * {
      flex-grow: 0 !important; }

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
    ${BOXES} > * { padding-bottom: 0.3em !important; min-width: 0; }
    ${BOXES} > :has(.llsrbm-boxes, .llsrbm-wide) { grid-column: 1 / -1; }
    ${BOXES} ${FIELD} { width: auto !important; padding-right: 0; flex-shrink: 1 !important; }

    ${PAIRS} { display: grid; grid-template-columns: 1fr 1fr; column-gap: 6px; }
    ${PAIRS} > * { grid-column: 1 / -1; min-width: 0; }
    ${PAIRS} > :has(> .mantine-Button-root) { grid-column: auto; }

    /* The verdict has the same height whatever it says: what stands below must not jump. */
    .llsrbm-status > [role=status] { height: ${VERDICT}; overflow-y: auto; margin: 0.3rem 0;
      box-sizing: border-box; padding: 0.1rem 0.7rem; font-size: 0.8rem; line-height: 1.35;
      border-left: 4px solid var(--verdict); overflow-wrap: anywhere; }
    .llsrbm-status b { font-size: 1.3rem; line-height: 1.25; margin-right: 0.3em; }
    .llsrbm-status dl { display: grid; grid-template-columns: repeat(3, 1fr); margin: 0.25rem 0 0; }
    .llsrbm-status dt { font-size: 0.72rem; color: var(--mantine-color-dimmed); }
    .llsrbm-status dd { font-size: 1rem; font-weight: 600; margin: 0; white-space: nowrap;
      font-variant-numeric: tabular-nums; }
    .llsrbm-status ul { margin: 0.1rem 0 0; padding-left: 1.1em; }
    .llsrbm-status.outdated > [role=status] { color: var(--mantine-color-dimmed); }
    .llsrbm-status [aria-busy=true] > :is(dl, ul) { animation: llsrbm-stale 0.2s 0.5s forwards; }
    @keyframes llsrbm-stale { to { color: var(--mantine-color-dimmed); opacity: 0.6; } }
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

  // `icons`, `format`, `save`: the first row; `menus`: two in a row; `armed`: likewise, while the
  // second one is there; `nearest`: lies on the verdict before it, at the top right; `main`: to be
  // pressed; `cancel` beside it, while there is something to cancel.
  function arrangement({ icons, format, save, menus, armed, nearest, main, cancel }) {
    const [type, arms] = armed, both = `${MAIN}:has([id$="${arms}"])`;
    const field = (uuid) => `:is(${row(uuid)}, ${row(uuid)} > div) > ${FIELD}`;
    return `
      ${icons.map(row).join()} { grid-column: span 2; }
      :is(${icons.map(button).join()}) { padding: 0 !important; }
      :is(${icons.map(button).join()}) .mantine-Button-section { margin: 0; font-size: 1.1rem; }
      :is(${icons.map(button).join()}) svg { left: 0; }
      :is(${icons.map(button).join()}) .mantine-Button-label, ${field(format)} { position: absolute;
        width: 1px !important; height: 1px; padding: 0; clip-path: inset(50%); overflow: hidden; }
      ${row(format)} { grid-column: span 6; }
      ${row(save)} { grid-column: span 6; }
      ${row(menus[0])} { grid-column: span 10; }
      ${row(menus[1])} { grid-column: span 10; }
      ${field(menus[0])}, ${field(menus[1])} { width: 2.9rem !important; padding-right: 0; }
      ${both} > :has([id$="${type}"]) { grid-column: span 12; }
      ${row(arms)} { grid-column: span 8; }
      ${field(arms)} { width: 2.9rem !important; padding-right: 0; }
      ${both} ${FIELD}:has([for$="${type}"]) { width: 4.2rem !important; padding-right: 0; }
      ${row(nearest)} { position: relative; height: 0; padding: 0 !important; z-index: 1; }
      ${button(nearest)} { position: absolute; right: 0; bottom: calc(${VERDICT} - 1.1rem);
        width: auto; height: 1.7rem; border-color: #d08a1d; }
      ${MAIN}:has([id="${nearest}"]) .llsrbm-status > [role=status]::before { content: "";
        float: right; width: 5.8rem; height: 1.7rem; } /* its words go around the button */
      ${row(cancel)} { grid-column: span 6; }
      ${MAIN}:has([id="${cancel}"]) > :has([id$="${main}"]) { grid-column: span 14; }
      ${button(main)}, ${button(main)}:not([data-disabled]):hover {
        background: ${FILLED}; color: #fff; border-color: transparent; }
      ${button(main)}[data-disabled] { opacity: 0.5; }`;
  }

  // A square of an overlay's colours before its label; where it shows nothing now, both are grey.
  function swatch(uuid, colours) {
    const label = `${BOXES} label[for="${uuid}"]`;
    const share = 100 / colours.length;
    const stops = colours.map((colour, k) => `${colour} ${k * share}% ${(k + 1) * share}%`);
    return colours.length
      ? `${label} { color: var(--mantine-color-text); }
        ${label}::before { border: 0; background: linear-gradient(90deg, ${stops}); }`
      : "";
  }

  const arranged = window.llsrbm.element("style"), tinted = window.llsrbm.element("style");
  window.llsrbm.addToPage(STYLE, arranged, tinted);

  window.llsrbm.panel = {
    arrange: (controls) => (arranged.textContent = arrangement(controls)),
    setShortcuts: (on) => (window.llsrbm.shortcuts = on),
    swatches(colours) {
      tinted.textContent = Object.entries(colours).map(([uuid, of]) =>
        `${BOXES} label[for="${uuid}"]::before { content: ""; box-sizing: border-box;
          display: inline-block; width: 0.75em; height: 0.75em; margin-right: 0.4em;
          border-radius: 2px; border: 1px solid var(--mantine-color-default-border); }
        ${swatch(uuid, of)}`).join("\n");
    },
  };
})();
