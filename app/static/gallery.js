// The gallery: designs to start from, each as a card with a moving picture, a title and a line. The
// server sends the cards once (app/gallery.py), when they are to be seen. Below them are the motions of
// the library, whose stick figures are asked for as they come into view.
(() => {
  const { page, element, addToPage, dialog: { chooser } } = window.llsrbm;
  const AHEAD = "300px"; // above and below what is seen: figures are there when they come into view
  const STILL = matchMedia("(prefers-reduced-motion: reduce)").matches;

  const STYLE = `
    #llsrbm-gallery .cards { display: grid; gap: 12px; padding: 14px 16px 18px;
      grid-template-columns: repeat(auto-fill, minmax(11rem, 1fr)); }
    #llsrbm-gallery .cards button { display: flex; flex-direction: column; align-items: stretch;
      padding: 0; overflow: hidden; text-align: left; }
    #llsrbm-gallery .picture { display: block; width: 100%; aspect-ratio: 4 / 3; background: #dde4ea;
      object-fit: cover; }
    #llsrbm-gallery .cards b { padding: 7px 10px 0; }
    #llsrbm-gallery .cards span { padding: 2px 10px 9px; font-size: 13px;
      color: var(--mantine-color-dimmed); }
    #llsrbm-gallery section { padding: 4px 16px 18px; border-top: 1px solid
      var(--mantine-color-default-border); }
    #llsrbm-gallery h3 { margin: 10px 0 0; font-size: 1.05rem; }
    #llsrbm-gallery section p { margin: 2px 0; }
    #llsrbm-gallery .filters { display: flex; flex-wrap: wrap; gap: 6px 18px; align-items: center;
      margin: 8px 0; }
    #llsrbm-gallery label { display: flex; gap: 6px; align-items: center; }
    #llsrbm-gallery select { font: inherit; color: inherit; padding: 4px 6px; border-radius: 4px;
      background: var(--mantine-color-default); border: 1px solid var(--mantine-color-default-border); }
    #llsrbm-gallery .motions { display: grid; gap: 8px;
      grid-template-columns: repeat(auto-fill, minmax(15rem, 1fr)); }
    #llsrbm-gallery .motions button { display: flex; flex-direction: column; text-align: left;
      padding: 6px 10px; }
    #llsrbm-gallery .motions span { font-size: 13px; color: var(--mantine-color-dimmed); }
    #llsrbm-gallery .motions i { height: 84px; margin-top: auto; padding-top: 4px; color: var(--mantine-color-anchor); }
    #llsrbm-gallery .motions svg { width: 100%; height: 100%; }`;

  const grid = element("div", { class: "cards" });
  const dialog = chooser("llsrbm-gallery", "Examples",
    "Choose one: it is planned and played, and every slider goes on from there.", grid);

  // ---- the library: certified motions, opened as a file is

  const list = element("div", { class: "motions" });
  const count = element("p", { role: "status" });
  const chosen = { robot: "", kind: "" };
  let motions = [], buttons = new Map();

  function motion({ name, robot, kind, line }) {
    return element("button", {
      type: "button", title: name,
      onclick() {
        dialog.close();
        page.send({ kind: "motion", name });
      },
    }, element("b", {}, `${robot}: ${kind}`), element("span", {}, line), element("i"));
  }

  // A stick figure has two kilobytes: those of motions that nobody scrolls to are never sent.
  const coming = new IntersectionObserver((entries) => {
    const near = entries.filter((entry) => entry.isIntersecting).map(({ target }) => target);
    if (!near.length) return;
    for (const button of near) coming.unobserve(button);
    page.send({ kind: "figures", names: near.map((button) => button.title) });
  }, { root: dialog, rootMargin: AHEAD });

  function showMotions() {
    const kept = motions.filter((each) =>
      Object.entries(chosen).every(([name, value]) => !value || each[name] === value));
    count.textContent = `${kept.length} of ${motions.length}`;
    list.replaceChildren(...kept.map(({ name }) => buttons.get(name)));
  }

  function choice(name, label) {
    const values = [...new Set(motions.map((each) => each[name]))].sort();
    const select = element("select", {
      onchange() {
        chosen[name] = select.value;
        showMotions();
      },
    }, ...["", ...values].map((value) => element("option", { value }, value || "all")));
    return element("label", {}, label, select);
  }

  function fillLibrary(found) {
    motions = found;
    buttons = new Map(motions.map((each) => [each.name, motion(each)]));
    for (const button of buttons.values()) coming.observe(button);
    if (!motions.length) return;
    dialog.append(element("section", { "aria-label": "Library" },
      element("h3", {}, "Library"),
      element("p", {}, "Certified motions that land strictly in simulation: each opens at once."),
      element("div", { class: "filters" }, choice("robot", "Made for"), choice("kind", "Kind"), count),
      list));
    showMotions();
  }
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
    fill(cards, found) {
      fillLibrary(found);
      grid.replaceChildren(...cards.map(card));
      window.llsrbm.tour.invite(card(cards[0]));
    },
    animate(figures) {
      for (const [name, figure] of Object.entries(figures))
        buttons.get(name)?.querySelector("i").append(window.llsrbm.stickFigure(figure));
    },
    open() {
      if (!dialog.open) dialog.showModal();
    },
  };
})();
