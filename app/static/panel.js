// How the panel looks: rows in a grid that scrolls as one, sliders as wide as it, one filled button,
// labels that do not wrap, readable greys. viser draws the controls; this script only adds style
// sheets. `arrange` learns from the server which control is which; markers in the panel's own HTML
// (app/panel) say where the rest belongs.
(() => {
  const { boxOf } = window.llsrbm.layout;
  const MAIN = boxOf("llsrbm-status"); // the box with the controls that are always there
  const BOXES = boxOf("llsrbm-boxes"); // a box of checkboxes
  const FOLDER = ".mantine-Paper-root:has(> .mantine-Paper-root:first-child > svg.tabler-icon)";
  const SCENARIO = boxOf("llsrbm-scenario"); // the box of what a simulation meets
  const PAIRS = boxOf("llsrbm-pair"); // a box whose buttons stand side by side
  const FIELD = ".mantine-Flex-root > div:first-child"; // the place of a label
  const TABS = "[data-dock-area^=gui-tabs]"; // the tabs of the details
  // A row with a slider: its label and number, and below them the slider.
  const SLIDER = ".mantine-Flex-root:has(> div .mantine-Slider-root)";

  const VERDICT = "8.2rem"; // least height of the verdict: what is usual has room, what is more grows

  const FILLED = "rgb(62 78 99)"; // the brand's, dark enough for white letters

  const STYLE = `
    :root[data-mantine-color-scheme=light] { --mantine-color-dimmed: #59616a !important; }
    :root[data-mantine-color-scheme=dark] { --mantine-color-dimmed: #b4bac2 !important; }
    .mantine-Notification-description { color: var(--mantine-color-dimmed) !important; }

    /* viser has letters of less than 12 pixels, drawn together. */
    body * { letter-spacing: normal !important; }
    ${MAIN} { font-size: 14px; }
    #root :is(p, code, .mantine-Paper-root) { font-size: max(12px, 1em) !important; }
    ${MAIN} :is(input, label, p, .mantine-Slider-markLabel) { font-size: 13px !important; }
    ${MAIN} .mantine-Slider-markLabel { font-size: 12px !important; line-height: 1;
      color: var(--mantine-color-dimmed); white-space: nowrap; }

    ${MAIN} { display: grid; grid-template-columns: repeat(20, minmax(0, 1fr)); column-gap: 6px;
      box-sizing: border-box; align-content: start; padding: 0.4em 12px 1rem !important; }
    ${MAIN} > * { grid-column: 1 / -1; min-width: 0; margin-inline: 0 !important;
      padding-inline: 0 !important; }
    ${MAIN} > div > ${FIELD}, ${MAIN} > div > div > ${FIELD} { width: 7.6rem !important;
      padding-right: 6px; }
    ${MAIN} label { white-space: nowrap; }

    ${SLIDER} { display: grid; grid-template-columns: minmax(0, 1fr) auto; row-gap: 1px; }
    ${SLIDER} > div:last-child, ${SLIDER} > div:last-child div:has(> .mantine-Flex-root),
    ${SLIDER} .mantine-Flex-root { display: contents; }
    ${SLIDER} .mantine-Slider-root { --slider-size: 6px; grid-row: 2; grid-column: 1 / -1;
      padding: 5px 2px 21px !important; margin: 0 !important; position: relative; }
    ${SLIDER} .mantine-Slider-thumb { width: 14px !important; height: 20px !important;
      border-radius: 4px; }
    ${SLIDER} .mantine-Slider-mark { display: none; }
    ${SLIDER} .mantine-Slider-label { display: none; } /* the number stands above */
    ${SLIDER} .mantine-Slider-root .mantine-Slider-markWrapper .mantine-Slider-markLabel {
      transform: translate(-6px, 10px) !important; }
    ${SLIDER} .mantine-Slider-root .mantine-Slider-markWrapper:last-child .mantine-Slider-markLabel {
      transform: translate(calc(6px - 100%), 10px) !important; }
    ${SLIDER} .mantine-NumberInput-root { width: 4.4rem !important; margin: 0 !important; }
    ${SLIDER} .mantine-NumberInput-input { text-align: right; }
    ${MAIN} > :has(> ${SLIDER}) { padding-bottom: 2px !important; }

    /* The details' tabs are as high as what is in them: the panel scrolls, and nothing in it. */
    ${TABS}, ${TABS} > *, ${TABS} .mantine-ScrollArea-root { overflow: visible !important; }
    ${TABS} .mantine-ScrollArea-viewport { max-height: none !important;
      overflow: visible !important; }
    ${TABS} .mantine-ScrollArea-scrollbar { display: none !important; }
    ${TABS} .mantine-ScrollArea-viewport > div { display: block !important; min-width: 0 !important;
      overflow-x: clip; }

    /* A folder: a line with its title, which is a button (accessibility.js), and what it holds. */
    ${FOLDER} { border-width: 1px 0 0; border-radius: 0; margin: 0 0 4px !important; }
    ${FOLDER} > .mantine-Paper-root { position: static; transform: none; padding: 3px 0;
      display: flex; align-items: center; justify-content: space-between; font-size: 14px; }
    ${FOLDER} > :last-child { display: none; }
    ${SCENARIO} { padding: 0 !important; display: grid; grid-template-columns: 1fr 1fr; column-gap: 10px;
      align-items: center; }
    ${SCENARIO} > * { min-width: 0; padding: 0 0 5px !important; margin-inline: 0 !important; }
    ${SCENARIO} > :has(.mantine-Slider-root, .llsrbm-wide, .mantine-Button-root) {
      grid-column: 1 / -1; }
    ${SCENARIO} ${FIELD} { width: auto !important; flex: 1 1 auto !important;
      padding-right: 2px !important; }
    ${SCENARIO} .mantine-NumberInput-root { width: 62px; margin-left: auto; }
    ${SCENARIO} .mantine-NumberInput-input { padding-left: 4px !important; }

    ${BOXES} > *, ${SCENARIO} > * { padding-inline: 0 !important; margin-inline: 0 !important; }
    :is(${BOXES}, ${SCENARIO}) .mantine-Flex-root:has([type=checkbox]) {
      flex-direction: row-reverse; justify-content: flex-end; gap: 6px; }
    :is(${BOXES}, ${SCENARIO}) .mantine-Flex-root:has([type=checkbox]) > * {
      flex-grow: 0 !important; }

    /* Every button is quiet but the one that is there to be pressed. */
    .mantine-Button-root[data-block], .mantine-Button-root[data-variant=outline] {
      background: var(--mantine-color-default); color: var(--mantine-color-text);
      border: 1px solid var(--mantine-color-default-border); font-size: 13px; }
    .mantine-Button-root[data-block]:not([data-disabled]):hover {
      background: var(--mantine-color-default-hover); color: var(--mantine-color-text); }
    .mantine-Button-root[data-block][data-disabled] { background: transparent;
      color: var(--mantine-color-dimmed); border-style: dashed; }
    .mantine-Button-root[data-block] { padding-inline: 0.5rem; }

    [role=tab] * { font-size: 13px !important; }
    ${TABS} [role=tablist] { display: flex; flex-wrap: nowrap !important; }
    ${TABS} [role=tab] { flex: 1 1 auto !important; min-width: 0; justify-content: center;
      padding-inline: 3px !important; font-size: 13px !important; opacity: 1 !important;
      color: var(--mantine-color-dimmed) !important; }
    ${TABS} [role=tab][aria-selected=true] { color: var(--mantine-color-text) !important; }

    ${BOXES} { display: grid; grid-template-columns: repeat(2, minmax(0, 1fr)); column-gap: 2px;
      padding: 0; }
    ${FOLDER} ${FOLDER} ${BOXES} { grid-template-columns: minmax(0, 1fr); }
    ${BOXES} > * { padding-bottom: 0.3em !important; min-width: 0; }
    ${BOXES} > :has(.llsrbm-boxes, .llsrbm-wide) { grid-column: 1 / -1; }
    ${BOXES} ${FIELD} { width: auto !important; padding-right: 0; flex-shrink: 1 !important; }

    ${PAIRS} { display: grid; grid-template-columns: 1fr 1fr; column-gap: 6px; }
    ${PAIRS} > * { grid-column: 1 / -1; min-width: 0; }
    ${PAIRS} > :has(> .mantine-Button-root) { grid-column: auto; }
    ${PAIRS} .mantine-Button-root { padding-inline: 2px; }

    .llsrbm-far { margin: 0 0 4px; padding: 2px 8px; font-size: 13px; line-height: 1.35;
      border-left: 4px solid #2f9e62; overflow-wrap: anywhere; }
    .llsrbm-far.busy { border-color: #d08a1d; }
    .llsrbm-far.old { border-color: #8a94a0; color: var(--mantine-color-dimmed); }

    /* The verdict grows with what it says; what is usual leaves what stands below where it is. */
    .llsrbm-status > [role=status] { min-height: ${VERDICT}; margin: 0.3rem 0; box-sizing: border-box;
      padding: 0.1rem 0 0.1rem 0.7rem; font-size: 13px; line-height: 1.4;
      border-left: 4px solid var(--verdict); overflow-wrap: anywhere; }
    .llsrbm-status b { font-size: 21px; line-height: 1.3; margin-right: 0.3em; }
    .llsrbm-checks { display: inline-block; padding: 0 0.5em; border-radius: 0.7em; font-size: 12px;
      line-height: 1.4rem; vertical-align: 0.2em; border: 1px solid; white-space: nowrap;
      color: color-mix(in srgb, var(--checks) 60%, var(--mantine-color-text)); }
    .llsrbm-checks.held { --checks: #2f9e62; }
    .llsrbm-checks.broken { --checks: #d6336c; }
    .llsrbm-status dl { display: grid; grid-template-columns: 1fr 1fr; gap: 0.15rem 0.6rem;
      margin: 0.25rem 0 0; }
    .llsrbm-status dt { font-size: 12px; color: var(--mantine-color-dimmed); }
    .llsrbm-status dd { font-size: 16px; font-weight: 600; margin: 0; line-height: 1.25;
      font-variant-numeric: tabular-nums; }
    .llsrbm-status ul { margin: 0.1rem 0 0; padding-left: 1.1em; }
    .llsrbm-status.outdated > [role=status] { color: var(--mantine-color-dimmed); }
    /* Figures of the motion before: at once is not soon enough to be read. */
    .llsrbm-status .old dd { animation: llsrbm-old 0.2s 0.5s forwards; }
    .llsrbm-status .old dd::before { content: "was "; font-size: 0; font-weight: normal;
      animation: llsrbm-was 0s 0.5s forwards; }
    @keyframes llsrbm-old { to { color: var(--mantine-color-dimmed); font-weight: normal; } }
    @keyframes llsrbm-was { to { font-size: 12px; } }
    .llsrbm-progress { height: 3px; border-radius: 2px; overflow: hidden; margin: 0 0 4px; }
    .llsrbm-progress.unknown { background: linear-gradient(90deg, transparent,
      var(--mantine-primary-color-filled), transparent) 0 0 / 40% 100% no-repeat;
      animation: llsrbm-runs 1.6s 0.5s linear infinite backwards; }
    @keyframes llsrbm-runs { from { background-position: -70% 0; } to { background-position: 170% 0; } }
    @media (prefers-reduced-motion: reduce) { .llsrbm-progress.unknown { animation: none; } }
    .llsrbm-progress > div { height: 100%; background: var(--mantine-primary-color-filled); }
    .llsrbm-progress > .lasts { width: 95%; transform-origin: left;
      animation: llsrbm-lasts linear backwards; }
    @keyframes llsrbm-lasts { from { transform: scaleX(0); } }
    @media (prefers-reduced-motion: reduce) { .llsrbm-progress > .lasts { width: 0; animation: none; } }
    .llsrbm-seeds { display: grid; grid-template-columns: repeat(5, 1fr); gap: 3px; margin-top: 4px;
      font-variant-numeric: tabular-nums; list-style: none; padding: 0; }
    .llsrbm-seeds > li { border: 1px solid var(--mantine-color-default-border); border-radius: 3px;
      padding: 0 4px; white-space: nowrap; }
    .llsrbm-seeds > .fell { border-color: #d6336c; background: #d6336c22; }
    .llsrbm-seeds > .worst { outline: 2px solid currentColor; font-weight: bold; }

    .llsrbm-tuning { padding: 0; font-size: 12px; }
    .llsrbm-tuning table { border-spacing: 0; width: 100%; margin-bottom: 0.6em; }
    .llsrbm-tuning caption { text-align: left; font-weight: bold; padding: 0.2em 0; }
    .llsrbm-tuning th { text-align: left; font-weight: normal; white-space: nowrap; padding: 1px 0; }
    .llsrbm-tuning thead th { color: var(--mantine-color-dimmed); }
    .llsrbm-tuning td { white-space: nowrap; padding: 1px 0 1px 4px; }
    .llsrbm-tuning tbody th { cursor: help; white-space: normal; line-height: 1.15; }
    .llsrbm-tuning .number { text-align: right; font-variant-numeric: tabular-nums; }
    .llsrbm-tuning input { width: 4.1em; font: inherit; text-align: right; padding: 1px 2px;
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

    /* viser's note on a download: whole, and beside the camera's buttons. */
    .mantine-Notifications-root { top: 52px !important; }
    .mantine-Notification-body * { white-space: normal !important; overflow-wrap: anywhere;
      font-size: 13px !important; }

    /* viser's own buttons are there for a pointer or the keys. */
    @media (hover: hover) {
      :not(:hover, :focus-within) > :is([aria-label="Collapse panel area"],
        [aria-label="Minimize panel"], [aria-label="Connection and scene tree"]) { opacity: 0; } }

    :is(button, input, select, [role=tab], [role=button], [role=slider]):focus-visible {
      outline: 2px solid var(--mantine-primary-color-filled) !important; outline-offset: 1px; }`;

  const row = (uuid) => `${MAIN} > :has([id$="${uuid}"])`;
  const button = (uuid) => `.mantine-Button-root[id="${uuid}"]`;

  // `examples`, `icons`: the first row; `menus`: robot, type and, while it is there, arms, in one row, each below
  // its label; `model`: its menu, and what compares models; `nearest`: lies on the verdict before it,
  // at the lower right; `far`: each beside the number of the slider below it, with its name; `largest`:
  // beside the sentence on what they found; `main`: to be pressed;
  // `cancel` beside it, while there is something to cancel; `choose`, `format`, `save`: in one row.
  function arrangement(controls) {
    const { examples, icons, choose, format, save, menus, model, nearest, main, cancel } = controls;
    const far = controls.far.map(([uuid]) => uuid), { largest } = controls;
    const [robot, type, arms] = menus, armed = `${MAIN}:has([id$="${arms}"])`;
    const field = (uuid) => `:is(${row(uuid)}, ${row(uuid)} > div) > ${FIELD}`;
    const flex = (uuid) => `:is(${row(uuid)}, ${row(uuid)} > div) > .mantine-Flex-root`;
    return `
      ${row(examples)} { grid-column: span 10; }
      ${icons.map(row).join()} { grid-column: span 2; }
      :is(${icons.map(button).join()}) { padding: 0 !important; }
      :is(${icons.map(button).join()})[data-disabled] { opacity: 0; }
      :is(${icons.map(button).join()}) .mantine-Button-section { margin: 0; font-size: 18px; }
      :is(${icons.map(button).join()}) svg { left: 0; }
      :is(${icons.map(button).join()}) .mantine-Button-label, ${field(format)} { position: absolute;
        width: 1px !important; height: 1px; padding: 0; clip-path: inset(50%); overflow: hidden; }
      ${row(choose)} { grid-column: span 7; }
      ${row(format)} { grid-column: span 8; }
      ${row(save)} { grid-column: span 5; }
      ${menus.map(flex).join()} { flex-direction: column; align-items: stretch !important; }
      ${menus.map(field).join()} { width: auto !important; padding: 0; }
      ${row(robot)} { grid-column: 1 / span 10; }
      ${row(type)} { grid-column: span 10; }
      ${armed} > :has([id$="${robot}"]) { grid-column: 1 / span 8; }
      ${armed} > :has([id$="${type}"]) { grid-column: span 8; }
      ${armed} > :has([id$="${arms}"]) { grid-column: span 4; }
      ${row(model[0])} { grid-column: span 11; }
      ${field(model[0])} { width: 3.2rem !important; padding: 0; }
      ${row(model[1])} { grid-column: span 9; }
      ${row(nearest)} { position: relative; height: 0; padding: 0 !important; z-index: 1; }
      ${button(nearest)} { position: absolute; right: 0; bottom: 0.7rem; width: auto; height: 1.7rem;
        border-color: #d08a1d; }
      ${MAIN}:has([id="${nearest}"]) .llsrbm-status > [role=status] { padding-bottom: 2.1rem; }
      ${far.map(row).join()} { position: relative; height: 0; padding: 0 !important; z-index: 1; }
      :is(${far.map(button).join()}) { position: absolute; right: 4.8rem; top: -2px;
        width: auto; height: 24px; font-size: 12px; padding-inline: 7px; }
      /* There for a pointer or a finger on the slider, or the keys. */
      :is(${far.map(row).join()}):not(:hover, :focus-within, :has(+ :is(:hover, :focus-within)))
        .mantine-Button-root { opacity: 0; }
      ${row(largest)} { grid-column: span 6; align-self: center; }
      ${button(largest)} { padding-inline: 2px; border-color: #2f9e62; }
      ${MAIN}:has([id="${largest}"]) > :has(.llsrbm-far) { grid-column: span 14; }
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

  // Ctrl+Z and Ctrl+Y or Ctrl+Shift+Z, unless something is typed that has an undo of its own.
  let undoing = null, redoing = null; // uuids of the buttons
  window.addEventListener("keydown", (event) => {
    const { key, ctrlKey, metaKey, altKey, shiftKey, target } = event;
    if (!window.llsrbm.shortcuts || !(ctrlKey || metaKey) || altKey) return;
    if (target instanceof Element && target.closest("input:not([type=checkbox]), textarea")) return;
    const letter = key.toLowerCase(), again = letter === "y" || (letter === "z" && shiftKey);
    if (letter !== "z" && !again) return;
    event.preventDefault();
    document.getElementById(again ? redoing : undoing)?.click();
  }, { capture: true });

  const arranged = window.llsrbm.element("style"), tinted = window.llsrbm.element("style");
  window.llsrbm.addToPage(STYLE, arranged, tinted);

  // Buttons that read alike have a name each. viser makes its elements anew now and then.
  let alike = [];
  function name() {
    for (const [uuid, of] of alike)
      document.getElementById(uuid)?.setAttribute("aria-label", `How far? ${of}`);
  }
  window.llsrbm.layout.onChange(name);

  window.llsrbm.panel = {
    arrange(controls) {
      arranged.textContent = arrangement(controls);
      alike = controls.far;
      name();
      ({ undo: undoing, redo: redoing } = controls);
    },
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
