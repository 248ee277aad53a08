// Chips over the picture, at its top right: the design that is shown and what is pinned beside it, by
// colour and name. A click makes a pin's design the present one, its cross lets go of it; another
// button has the pinned robots stand beside the one that is shown, under the same camera.
(() => {
  const { page, layout, element, swatch, addToPage } = window.llsrbm;

  const STYLE = `
    #llsrbm-pins { top: 10px; right: 10px; max-width: 55%; display: flex; flex-wrap: wrap; gap: 4px;
      justify-content: flex-end; font: 12px system-ui, sans-serif; }
    #llsrbm-pins:empty { display: none; }
    #llsrbm-remark:not(:empty) ~ #llsrbm-pins { top: 66px; }
    #llsrbm-pins > * { display: flex; align-items: center; gap: 5px; min-height: 26px;
      padding: 0 8px; border-radius: 13px; color: var(--mantine-color-text);
      background: var(--mantine-color-body); border: 1px solid var(--mantine-color-default-border); }
    #llsrbm-pins button { font: inherit; color: inherit; cursor: pointer; }
    #llsrbm-pins span button { padding: 0 2px; min-height: 24px; background: none; border: 0; }
    #llsrbm-pins > [aria-pressed=true] { background: var(--mantine-primary-color-light); }
    #llsrbm-pins i { width: 10px; height: 10px; border-radius: 3px; flex: none; }
    #llsrbm-pins .name { max-width: 15em; overflow: hidden; text-overflow: ellipsis;
      white-space: nowrap; }`;

  const bar = element("div", { id: "llsrbm-pins", role: "group", "aria-label": "Pinned designs" });

  const press = (act, index) => page.send({ kind: "pin", act, index });

  function chip({ title, colour }, index) {
    if (index < 0)
      return element("span", {}, swatch(colour), element("span", { class: "name" }, title));
    return element("span", {}, swatch(colour),
      element("button", { type: "button", class: "name", title: `Use this design: ${title}`,
        "aria-label": `Use ${title}`, onclick: () => press("use", index) }, title),
      element("button", { type: "button", title: "Unpin", "aria-label": `Unpin ${title}`,
        onclick: () => press("unpin", index) }, "✕"));
  }

  layout.over.append(bar);
  addToPage(STYLE);

  window.llsrbm.pins = {
    // Names and colours, the first that of the design that is shown; whether they stand side by side.
    show(chips, beside) {
      bar.replaceChildren(...(chips.length < 2 ? [] : [
        ...chips.map((each, i) => chip(each, i - 1)),
        element("button", { type: "button", "aria-pressed": beside,
          title: "Show the pinned robots beside this one, under the same camera",
          onclick: () => page.send({ kind: "beside", on: !beside }) }, "Side by side"),
      ]));
    },
  };
})();
