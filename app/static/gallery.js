// The gallery: designs to start from, each as a card with a moving picture, a title and a line. The
// server sends the cards once (app/gallery.py), when they are to be seen.
(() => {
  const { page, element, addToPage, dialog: { chooser } } = window.llsrbm;
  const STILL = matchMedia("(prefers-reduced-motion: reduce)").matches;

  const STYLE = `
    #llsrbm-gallery .cards { display: grid; gap: 12px; padding: 14px 16px 18px;
      grid-template-columns: repeat(auto-fill, minmax(11rem, 1fr)); }
    #llsrbm-gallery .cards button { display: flex; flex-direction: column; align-items: stretch;
      padding: 0; overflow: hidden; text-align: left; }
    #llsrbm-gallery .picture { display: block; width: 100%; aspect-ratio: 4 / 3; background: #dde4ea;
      object-fit: cover; }
    #llsrbm-gallery b { padding: 7px 10px 0; }
    #llsrbm-gallery .cards span { padding: 2px 10px 9px; font-size: 0.8125rem;
      color: var(--mantine-color-dimmed); }`;

  const grid = element("div", { class: "cards" });
  const dialog = chooser("llsrbm-gallery", "Examples",
    "Choose one: it is planned and played, and every slider goes on from there.", grid);
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
    fill(cards) {
      grid.replaceChildren(...cards.map(card));
      window.llsrbm.tour.invite(card(cards[0]));
    },
    open() {
      if (!dialog.open) dialog.showModal();
    },
  };
})();
