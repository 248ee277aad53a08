// Changes of the page, for the other scripts: where the picture is, and that viser has made elements
// anew. The only script that watches the page.
(() => {
  const llsrbm = window.llsrbm;
  const SETTLE = 200; // ms between two looks at what has changed
  const changed = [], moved = [];
  const boxes = []; // markers in the panel's own HTML
  const watched = new WeakSet();
  let later = 0;

  // As large as the picture, however the panel is docked: what lies over the picture has its place in
  // here.
  const over = llsrbm.element("div",
    { id: "llsrbm-over", role: "region", "aria-label": "Picture" });
  const resized = new ResizeObserver(follow);

  function watch(element) {
    if (!element || watched.has(element)) return;
    watched.add(element);
    resized.observe(element);
  }

  function follow() {
    const box = window.__viserMutable?.canvas?.getBoundingClientRect();
    if (!box) return;
    const { left, top, width, height } = box;
    for (const [name, value] of Object.entries({ left, top, width, height }))
      over.style[name] = `${value}px`;
    moved.forEach((listener) => listener(box));
  }

  // Marks the boxes of viser's in which a marker is. A rule like `div:has(> div > .marker)` would have
  // the browser style the whole page anew for every element that is made anywhere.
  function mark() {
    for (const marker of boxes) {
      const inside = [...document.querySelectorAll(`.${marker}`)].map(
        (each) => each.parentElement?.parentElement);
      for (const old of document.querySelectorAll(`[data-${marker}]`))
        if (!inside.includes(old)) old.removeAttribute(`data-${marker}`);
      for (const box of inside) box?.setAttribute(`data-${marker}`, "");
    }
  }

  // The selector of boxes with a marker's class.
  function boxOf(marker) {
    if (!boxes.includes(marker)) boxes.push(marker);
    return `[data-${marker}]`;
  }

  function look() {
    later = 0;
    watch(window.__viserMutable?.canvas);
    follow();
    changed.forEach((listener) => listener());
    if (!window.__viserMutable?.canvas) soon(); // viser notes it down a moment after it is there
  }

  const soon = () => (later ||= setTimeout(look, SETTLE));

  llsrbm.addToPage(`
    #llsrbm-over { position: fixed; z-index: 5; pointer-events: none; }
    #llsrbm-over > * { position: absolute; pointer-events: auto; }`, over);
  document.addEventListener("DOMContentLoaded", () => {
    new MutationObserver(() => {
      mark(); // before anything of it is drawn
      soon();
    }).observe(document.body, { childList: true, subtree: true });
    look();
  });
  window.addEventListener("resize", follow);
  // viser's page is as large as the window and has no bar to scroll back by: what a browser scrolls
  // into view by itself, while a new panel has not found its place, would leave it shifted.
  document.addEventListener("scroll", ({ target }) => {
    const canvas = window.__viserMutable?.canvas;
    if (canvas && target.contains(canvas)) (target.scrollingElement ?? target).scrollTo(0, 0);
  }, true);

  llsrbm.layout = {
    over, soon, watch, boxOf,
    get pending() { return later !== 0; }, // something changed that the scripts have not looked at
    onChange: (listener) => changed.push(listener), // elements were made anew, or taken away
    onMove: (listener) => moved.push(listener), // the picture, or what is watched, has another size
  };
})();
