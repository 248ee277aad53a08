// A small dialog of the page's own: a title, a sentence, and a line of text to copy.
(() => {
  const { element, addToPage } = window.llsrbm;
  const STYLE = `
    #llsrbm-dialog { max-width: min(34rem, 90vw); border: 1px solid var(--mantine-color-default-border);
      border-radius: 8px; padding: 1rem 1.2rem; font: 14px/1.5 system-ui, sans-serif;
      color: var(--mantine-color-text); background: var(--mantine-color-body); }
    #llsrbm-dialog::backdrop { background: rgba(0, 0, 0, 0.35); }
    #llsrbm-dialog h2 { margin: 0 0 0.3rem; font-size: 1.05rem; }
    #llsrbm-dialog input { box-sizing: border-box; width: 100%; font: inherit; padding: 0.3rem 0.5rem; }
    #llsrbm-dialog button { margin-top: 0.8rem; padding: 0.25rem 0.9rem; }
    :is(#llsrbm-dialog, #llsrbm-tour) :is(button, input), #llsrbm-transport :is(button, select) {
      font: inherit; color: inherit; background: var(--mantine-color-default); border-radius: 4px;
      border: 1px solid var(--mantine-color-default-border); }
    :is(#llsrbm-dialog, #llsrbm-tour, #llsrbm-transport) button { cursor: pointer; }`;

  const title = element("h2", { id: "llsrbm-dialog-title" });
  const text = element("p");
  const line = element("input", { readonly: "", "aria-label": "Link" });
  const close = element("button", { type: "button", onclick: () => dialog.close() }, "Close");
  const dialog = element("dialog",
    { id: "llsrbm-dialog", "aria-labelledby": "llsrbm-dialog-title" }, title, text, line, close);
  addToPage(STYLE, dialog);

  window.llsrbm.dialog = {
    open(heading, sentence, value) {
      title.textContent = heading;
      text.textContent = sentence;
      line.value = value;
      if (!dialog.open) dialog.showModal();
      line.select();
    },
  };
})();
