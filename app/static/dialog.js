// Dialogs of the page's own: a small one with a line of text to copy, and large ones to choose from.
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
    .llsrbm-chooser { width: min(62rem, 94vw); max-height: 88vh; box-sizing: border-box; padding: 0;
      border: 1px solid var(--mantine-color-default-border); border-radius: 10px;
      font: 14px/1.4 system-ui, sans-serif; color: var(--mantine-color-text);
      background: var(--mantine-color-body); }
    .llsrbm-chooser::backdrop { background: rgba(0, 0, 0, 0.45); }
    .llsrbm-chooser header { position: sticky; top: 0; z-index: 1; display: flex; align-items: center;
      gap: 1rem; padding: 0.7rem 1rem; background: var(--mantine-color-body);
      border-bottom: 1px solid var(--mantine-color-default-border); }
    .llsrbm-chooser h2 { margin: 0; font-size: 1.05rem; }
    .llsrbm-chooser header p { flex: 1; margin: 0; color: var(--mantine-color-dimmed); }
    .llsrbm-chooser button { font: inherit; color: inherit; cursor: pointer; border-radius: 8px;
      background: var(--mantine-color-default); border: 1px solid var(--mantine-color-default-border); }
    .llsrbm-chooser button:hover { border-color: var(--mantine-primary-color-filled); }
    .llsrbm-chooser header button { min-width: 32px; min-height: 30px; border-radius: 4px; }
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

  // A dialog that Escape, its cross or a press beside it closes: a title, a sentence or its element,
  // and what there is.
  function chooser(id, heading, sentence, ...choices) {
    const made = element("dialog", {
      id, class: "llsrbm-chooser", "aria-labelledby": `${id}-title`,
      onclick: ({ target }) => target === made && made.close(),
    }, element("header", {}, element("h2", { id: `${id}-title` }, heading),
      element("p", {}, sentence),
      element("button", { type: "button", "aria-label": `Close: ${heading}`,
        onclick: () => made.close() }, "✕")), ...choices);
    return made;
  }

  window.llsrbm.dialog = {
    chooser,
    open(heading, sentence, value) {
      title.textContent = heading;
      text.textContent = sentence;
      line.value = value;
      if (!dialog.open) dialog.showModal();
      line.select();
    },
  };
})();
