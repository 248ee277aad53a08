// The files that a motion can be saved as, by what they are for. The server says which there are, each
// time they are to be seen (app/tab/files.py); a press chooses one as the menu Format does, and exports.
(() => {
  const { page, element, addToPage, dialog: { chooser } } = window.llsrbm;

  const STYLE = `
    #llsrbm-exports .purposes { padding: 0 16px 18px; }
    #llsrbm-exports h3 { margin: 14px 0 6px; font-size: 14px; }
    #llsrbm-exports ul { display: grid; gap: 8px; margin: 0; padding: 0; list-style: none;
      grid-template-columns: repeat(auto-fill, minmax(min(17rem, 100%), 1fr)); }
    #llsrbm-exports li > * { display: grid; align-content: start; gap: 1px; width: 100%;
      height: 100%; box-sizing: border-box; padding: 7px 10px; text-align: left;
      overflow-wrap: anywhere; }
    #llsrbm-exports li > div { border: 1px dashed var(--mantine-color-default-border);
      border-radius: 8px; }
    #llsrbm-exports :is(b, span) { line-height: 1.35; }
    #llsrbm-exports span { font-size: 13px; color: var(--mantine-color-dimmed); }
    #llsrbm-exports span::first-letter { text-transform: uppercase; }
    #llsrbm-exports code { font-size: 12px; }`;

  const motion = element("span"), purposes = element("div", { class: "purposes" });
  const dialog = chooser("llsrbm-exports", "Export", motion, purposes);
  addToPage(STYLE, dialog);

  // `hindrance`: why it cannot be written here, and how that is mended.
  function choice({ name, what, file, hindrance }) {
    const words = [element("b", {}, name), element("span", {}, what)];
    if (hindrance) return element("div", {}, ...words, element("span", {}, hindrance));
    return element("button", {
      type: "button",
      onclick() {
        dialog.close();
        page.send({ kind: "export", format: name });
      },
    }, ...words, element("code", {}, file));
  }

  window.llsrbm.exports = {
    open(title, groups) {
      motion.textContent = `Choose a file for ${title}.`;
      purposes.replaceChildren(...groups.flatMap(([purpose, formats]) => [
        element("h3", {}, purpose),
        element("ul", { "aria-label": purpose },
          ...formats.map((each) => element("li", {}, choice(each))))]));
      if (!dialog.open) dialog.showModal();
    },
  };
})();
