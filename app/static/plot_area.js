// Keeps the area of the plots, a floating panel of viser's, below the picture: as wide as it, the
// picture above it, charts side by side where there is room. Dragged to a side of the page the panel
// is docked there by viser, and the picture has its height back.
// window.llsrbmPlots.watch(title, open, seen, add) begins: the panel's title, and controls of the
// server's: by `open` the area is opened, by `seen` the server learns whether it is; `add` is the
// button that adds a chart, and can be dragged onto one.
(() => {
  if (!window.llsrbmPlots || window.llsrbmPlots.watch) return;

  const MARKER = ".llsrbm-plot-area";
  const FLOATING = "[data-floating-window]";
  const PINNED = "data-llsrbm-pinned", GRID = "data-llsrbm-charts";
  const LOOK_EVERY = 300; // ms; what is resized is followed at once
  const SMALLEST = [1100, 700]; // pixels of a page in which the area is open at first

  document.head.append(window.llsrbm.element("style", {}, `
    [${PINNED}] { left: var(--llsrbm-left) !important; width: var(--llsrbm-width) !important;
      top: auto !important; bottom: 0 !important; border-radius: 0 !important; z-index: 6 !important;
      box-shadow: none !important; border-top: 1px solid var(--mantine-color-default-border); }
    [${PINNED}] [data-dock-strip] { display: none !important; }
    [${PINNED}]:not([style*="height"]) .mantine-ScrollArea-viewport { max-height: 46vh; }
    [${GRID}] { display: grid; align-items: start; padding-bottom: 4px;
      grid-template-columns: repeat(auto-fit, minmax(min(100%, 340px), 1fr)); }
    [${GRID}]:has(> :nth-child(3):last-child) {
      grid-template-columns: repeat(auto-fit, minmax(min(100%, max(340px, 40%)), 1fr)); }
    [${GRID}] > * { min-width: 0; }
    [${GRID}] > :has(${MARKER}) { grid-column: 1 / -1; position: sticky; top: 0; z-index: 110;
      background: var(--mantine-color-body); }
    [${GRID}] .uplot-container { margin: 0 6px 6px; }`));

  let title = null; // of viser's panel
  let boxes = null; // the server's checkboxes
  let pinned = null; // viser's window of the area
  let wrap = null; // the box of viser's that has the picture
  let seen = null; // whether the area was seen; null: not yet

  const resized = new ResizeObserver(() => place());

  function send(box, value) {
    window.__viserMutable?.sendMessage({ type: "GuiUpdateMessage", uuid: box, updates: { value } });
  }

  function look() {
    const marker = document.querySelector(MARKER);
    const found = marker ? marker.closest(FLOATING) : minimised();
    if (found !== pinned) {
      pinned?.removeAttribute(PINNED);
      if (pinned) resized.unobserve(pinned);
      pinned = found;
      pinned?.setAttribute(PINNED, "");
      if (pinned) resized.observe(pinned);
    }
    const root = document.querySelector("[data-dock-root]");
    const holder = [...(root?.children ?? [])].find((child) =>
      child.contains(window.__viserMutable?.canvas ?? null)) ?? null;
    if (holder !== wrap) {
      if (wrap) resized.unobserve(wrap);
      wrap = holder;
      if (wrap) resized.observe(wrap);
    }
    arrange(marker);
    place();
    window.llsrbm.plotDrag.offer(document.getElementById(boxes?.add));
    const visible = Boolean(marker?.getClientRects().length);
    if (boxes && seen !== null && visible !== seen) send(boxes.seen, visible);
    if (visible || seen !== null) seen = visible;
  }

  // A minimised panel has nothing but its title.
  function minimised() {
    const named = (panel) => panel.querySelector("[data-dock-tab]")?.textContent === title;
    return [...document.querySelectorAll(FLOATING)].find(named) ?? null;
  }

  // Whatever holds the legend and the charts is a grid.
  function arrange(marker) {
    let holder = marker;
    while (holder && !holder.querySelector(".uplot-container")) holder = holder.parentElement;
    if (!holder || holder.contains(wrap)) return;
    if (!holder.hasAttribute(GRID)) holder.setAttribute(GRID, "");
  }

  function place() {
    if (!wrap) return;
    const below = pinned ? `${pinned.offsetHeight}px` : "0px";
    if (wrap.style.bottom !== below) wrap.style.bottom = below;
    if (!pinned) return;
    pinned.style.setProperty("--llsrbm-left", `${wrap.offsetLeft}px`);
    pinned.style.setProperty("--llsrbm-width", `${wrap.offsetWidth}px`);
  }

  setInterval(look, LOOK_EVERY);

  window.llsrbmPlots.watch = (label, open, shown, add) => {
    title = label;
    boxes = { open, seen: shown, add };
    seen = null;
    look();
    if (window.innerWidth < SMALLEST[0] || window.innerHeight < SMALLEST[1]) send(open, false);
  };
})();
