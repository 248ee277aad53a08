// A legend in the picture, above the player's bar: colours of what is drawn, and what they mean.
(() => {
  const { layout, element, swatch, addToPage } = window.llsrbm;

  const STYLE = `
    #llsrbm-legend { left: 10px; margin: 0; padding: 3px 9px; display: flex; flex-wrap: wrap;
      gap: 1px 12px; width: max-content; max-width: calc(100% - 40px); list-style: none; border-radius: 6px;
      font: 12px/1.5 system-ui, sans-serif; color: var(--mantine-color-text);
      background: color-mix(in srgb, var(--mantine-color-body) 99.5%, transparent); pointer-events: none !important; }
    #llsrbm-legend:empty { display: none; }
    #llsrbm-legend li { display: flex; align-items: center; gap: 5px; white-space: nowrap; }
    #llsrbm-legend i { width: 14px; height: 3px; border-radius: 2px; }
    /* Where the picture is low it would lie over the robot; the tab View has the colours, too. */
    @media (max-width: 600px), (max-height: 650px) { #llsrbm-legend { display: none; } }`;

  const list = element("ul", { id: "llsrbm-legend", "aria-label": "Legend of the picture" });

  // The bar's height changes with the motion and the page.
  function place() {
    const bar = document.getElementById("llsrbm-transport");
    list.style.bottom = `${(bar?.offsetHeight ?? 0) + 8}px`;
  }

  layout.over.append(list);
  layout.onMove(place);
  layout.onChange(place);
  addToPage(STYLE);

  window.llsrbm.legend = {
    show(meanings) {
      list.replaceChildren(...meanings.map(([colour, words]) =>
        element("li", {}, swatch(colour), words)));
      place();
    },
  };
})();
