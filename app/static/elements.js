// Helpers of the other scripts: elements, and keys.
(() => {
  const llsrbm = window.llsrbm;
  llsrbm.shortcuts = true;
  const SVG = Object.assign(document.createElement("template"), { innerHTML: "<svg></svg>" })
    .content.firstChild.namespaceURI;

  // Attributes that begin with "on" are listeners.
  function fill(made, attributes, children) {
    for (const [name, value] of Object.entries(attributes)) {
      if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
      else made.setAttribute(name, value);
    }
    made.append(...children);
    return made;
  }
  llsrbm.element = (kind, attributes = {}, ...children) =>
    fill(document.createElement(kind), attributes, children);
  llsrbm.shape = (kind, attributes = {}, ...children) =>
    fill(document.createElementNS(SVG, kind), attributes, children);

  llsrbm.swatch = (colour) => {
    const made = llsrbm.element("i");
    made.style.background = colour;
    return made;
  };
  // A file is saved from what is in memory.
  llsrbm.save = (blob, name) => {
    const link = llsrbm.element("a", { href: URL.createObjectURL(blob), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };
  // Text that changes many times a second: a text that is replaced would have the browser style the
  // whole page anew, for its rules with :has().
  llsrbm.write = (place, text) => {
    if (place.firstChild?.nodeType !== Node.TEXT_NODE) place.replaceChildren(" ");
    if (place.firstChild.data !== text) place.firstChild.data = text;
  };

  // A style sheet, and elements of the page's own, as soon as there is a page.
  llsrbm.addToPage = (style, ...elements) =>
    document.addEventListener("DOMContentLoaded", () => {
      document.head.append(llsrbm.element("style", {}, style));
      document.body.append(...elements);
    });

  // ---- keys: they belong to the control that has the focus, if it uses them; the page's own can be
  // switched off (tab View).

  const TYPED_INTO = "input, textarea, select, [contenteditable], [role=slider], " +
    "[role=textbox], [role=application]";
  const CHOSEN_BY_ARROWS = "[role=tab], [role=option], [role=menuitem], [role=radio]";
  const PRESSED = `button, a[href], summary, [role=button], ${CHOSEN_BY_ARROWS}`;

  function isFree({ key, target, ctrlKey, altKey, metaKey }) {
    if (!llsrbm.shortcuts || ctrlKey || altKey || metaKey) return false;
    if (!(target instanceof Element)) return true;
    if (target.closest(TYPED_INTO)) return false;
    if (key !== " " && key.length === 1) return true;
    return !target.closest(key === " " ? PRESSED : CHOSEN_BY_ARROWS);
  }

  // `acts`: by key, letters in upper case; while `ready(event)`. Before viser sees them: it would
  // turn the camera with the arrows.
  llsrbm.listenToKeys = (acts, ready) => {
    const actOf = (event) => ready(event) && isFree(event)
      ? acts[event.key.length === 1 ? event.key.toUpperCase() : event.key] : undefined;
    window.addEventListener("keydown", (event) => {
      const act = actOf(event);
      if (!act) return;
      event.preventDefault();
      event.stopImmediatePropagation();
      act(event);
    }, { capture: true });
    // A button that has the focus would be clicked by a space that was just taken.
    window.addEventListener("keyup", (event) => {
      if (event.key === " " && actOf(event)) event.preventDefault();
    }, { capture: true });
  };
})();
