// The gallery: designs to start from, each as a card with a moving picture, a title and a line. The
// server sends the cards once (app/gallery.py), when they are to be seen.
(() => {
  const { page, element, addToPage } = window.llsrbm;
  const STILL = matchMedia("(prefers-reduced-motion: reduce)").matches;

  const STYLE = `
    #llsrbm-gallery { width: min(62rem, 94vw); max-height: 88vh; box-sizing: border-box; padding: 0;
      border: 1px solid var(--mantine-color-default-border); border-radius: 10px;
      font: 14px/1.4 system-ui, sans-serif; color: var(--mantine-color-text);
      background: var(--mantine-color-body); }
    #llsrbm-gallery::backdrop { background: rgba(0, 0, 0, 0.45); }
    #llsrbm-gallery header { position: sticky; top: 0; z-index: 1; display: flex; align-items: center;
      gap: 1rem; padding: 0.7rem 1rem; background: var(--mantine-color-body);
      border-bottom: 1px solid var(--mantine-color-default-border); }
    #llsrbm-gallery h2 { margin: 0; font-size: 1.05rem; }
    #llsrbm-gallery header p { flex: 1; margin: 0; color: var(--mantine-color-dimmed); }
    #llsrbm-gallery button { font: inherit; color: inherit; cursor: pointer; border-radius: 8px;
      background: var(--mantine-color-default); border: 1px solid var(--mantine-color-default-border); }
    #llsrbm-gallery header button { min-width: 32px; min-height: 30px; border-radius: 4px; }
    #llsrbm-gallery .cards { display: grid; gap: 12px; padding: 14px 16px 18px;
      grid-template-columns: repeat(auto-fill, minmax(11rem, 1fr)); }
    #llsrbm-gallery .cards button { display: flex; flex-direction: column; align-items: stretch;
      padding: 0; overflow: hidden; text-align: left; }
    #llsrbm-gallery .cards button:hover { border-color: var(--mantine-primary-color-filled); }
    #llsrbm-gallery .picture { display: block; width: 100%; aspect-ratio: 4 / 3; background: #dde4ea;
      object-fit: cover; }
    #llsrbm-gallery b { padding: 7px 10px 0; }
    #llsrbm-gallery .cards span { padding: 2px 10px 9px; font-size: 0.8125rem;
      color: var(--mantine-color-dimmed); }`;

  const grid = element("div", { class: "cards" });
  const close = element("button",
    { type: "button", "aria-label": "Close the examples", onclick: () => dialog.close() }, "✕");
  const dialog = element("dialog", {
    id: "llsrbm-gallery", "aria-labelledby": "llsrbm-gallery-title",
    onclick: ({ target }) => target === dialog && dialog.close(), // beside it
  }, element("header", {}, element("h2", { id: "llsrbm-gallery-title" }, "Examples"),
    element("p", {}, "Choose one: it is planned and played, and every slider goes on from there."),
    close), grid);
  addToPage(STYLE, dialog);

  // A picture that does not move, for those who asked for that.
  function still(address) {
    const canvas = element("canvas", { class: "picture", width: 192, height: 144 });
    const image = new Image();
    image.onload = () => canvas.getContext("2d").drawImage(image, 0, 0);
    image.src = address;
    return canvas;
  }

  function card({ name, title, line, note, picture }) {
    const shown = !picture ? element("div", { class: "picture" })
      : STILL ? still(picture) : element("img", { class: "picture", src: picture, alt: "" });
    return element("button", {
      type: "button", title: note,
      onclick() {
        dialog.close();
        page.send({ kind: "example", name });
      },
    }, shown, element("b", {}, title), element("span", {}, line));
  }

  window.llsrbm.gallery = {
    fill: (cards) => grid.replaceChildren(...cards.map(card)),
    open() {
      if (!dialog.open) dialog.showModal();
    },
  };
})();
