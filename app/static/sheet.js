// On a phone viser's panel floats over the picture. Here it is a sheet at the bottom, as wide as the
// page; the picture with its player takes what is above it. The title folds and unfolds it, as viser has it.
(() => {
  const { layout, addToPage } = window.llsrbm;
  const SHEET = "data-llsrbm-sheet";

  const STYLE = `
    [${SHEET}] { left: 0 !important; right: 0 !important; width: 100% !important;
      max-height: 52vh !important; border-radius: 12px 12px 0 0 !important; }
    [${SHEET}] > *, [${SHEET}] .mantine-ScrollArea-content > * { width: 100% !important; }
    [${SHEET}] .mantine-ScrollArea-viewport { overflow-x: hidden !important; }
    [${SHEET}] .mantine-ScrollArea-content { min-width: 0 !important; display: block !important; }`;

  let sheet = null;

  function look() {
    const status = document.querySelector(".llsrbm-status");
    const outside = status && !status.closest("[data-dock-root]");
    // The outermost box of viser's that has the panel and not the picture.
    const picture = window.__viserMutable?.canvas; // charts have canvases, too
    let found = outside && picture ? status : null;
    while (found?.parentElement && !found.parentElement.contains(picture)) found = found.parentElement;
    if (status && found === sheet) return;
    sheet?.removeAttribute(SHEET);
    sheet = found;
    sheet?.setAttribute(SHEET, "");
    layout.watch(sheet);
  }

  layout.onChange(look);
  addToPage(STYLE);

  window.llsrbm.sheet = {
    get height() { return sheet?.isConnected ? sheet.offsetHeight : 0; }, // pixels; 0: there is none
  };
})();
