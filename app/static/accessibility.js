// Names for what viser leaves nameless, so that a screen reader can say what a control is: sliders
// and the numbers beside them, icons, and the buttons that fold the panel and what is in it.
(() => {
  const LABELLED = ".mantine-Flex-root:has(label)"; // a row: a label, then its control
  const NUMBERS = "input.mantine-NumberInput-input, input.mantine-TextInput-input";
  const FOCUSABLE = "a, button, input, select, [tabindex]:not([tabindex='-1'])";
  const NAMED = "aria-label";

  const FOLDED = ".mantine-Paper-root > .mantine-Paper-root:first-child"; // the title of a folder

  function name(thing, text) {
    if (thing && text && thing.getAttribute(NAMED) !== text) thing.setAttribute(NAMED, text);
  }

  // The number has the label's own name; the thumb beside it is another way to the same value.
  function nameSliders() {
    for (const thumb of document.querySelectorAll("[role=slider].mantine-Slider-thumb")) {
      const row = thumb.closest(LABELLED);
      const label = row?.querySelector("label")?.textContent.trim();
      if (!label) continue;
      // Under the pointer it has a note of its own (tips.js).
      if (thumb.title !== label && !thumb.matches(":hover")) thumb.title = label;
      for (const number of row.querySelectorAll(NUMBERS)) name(number, label);
    }
  }

  // Numbers and texts without a label that points at them: viser's own settings.
  function nameFields() {
    for (const field of document.querySelectorAll(NUMBERS)) {
      if (field.labels?.length || field.getAttribute(NAMED)) continue;
      const row = field.closest(LABELLED);
      name(field, row?.querySelector("label")?.textContent.trim() || "Server");
    }
  }

  function nameIcons() {
    for (const icon of document.querySelectorAll("svg.tabler-icon[aria-label]")) {
      if (!icon.hasAttribute("role")) icon.setAttribute("role", "img");
    }
    for (const button of document.querySelectorAll("button.mantine-ActionIcon-root, " +
      "button.mantine-CloseButton-root, button.mantine-Notification-closeButton")) {
      if (button.textContent.trim() || button.getAttribute(NAMED)) continue;
      name(button, /close/i.test(button.className) ? "Close" : "Connection and scene tree");
    }
    for (const bar of document.querySelectorAll(".mantine-Progress-section[role=progressbar]"))
      name(bar, "Transfer of the file");
  }

  // viser's folders can be clicked; these can be reached and pressed with the keys, too.
  function openFolders() {
    for (const title of document.querySelectorAll(FOLDED)) {
      const arrow = title.querySelector("svg.tabler-icon");
      if (!arrow) continue;
      const open = String(arrow.classList.contains("tabler-icon-chevron-up"));
      if (title.getAttribute("aria-expanded") === open) continue;
      Object.assign(title, { role: "button", tabIndex: 0, ariaExpanded: open });
    }
  }
  document.addEventListener("click", ({ target }) => {
    const title = target instanceof Element ? target.closest(FOLDED) : null;
    if (title?.ariaExpanded) title.ariaExpanded = String(title.ariaExpanded !== "true");
  });
  document.addEventListener("keydown", (event) => {
    const { target, key } = event;
    if (!(target instanceof Element) || !target.matches(FOLDED)) return;
    if (key !== "Enter" && key !== " ") return;
    event.preventDefault();
    target.click();
  });

  // Areas that scroll and hold nothing to be focused can be scrolled with the keys, too.
  function reachScrolling() {
    for (const area of document.querySelectorAll("[data-scrollarea-viewport], .llsrbm-status > *")) {
      const scrolls = area.scrollHeight > area.clientHeight + 1;
      if (scrolls && !area.querySelector(FOCUSABLE)) area.tabIndex = 0;
      else if (area.hasAttribute("tabindex")) area.removeAttribute("tabindex");
    }
  }

  function nameParts() {
    document.documentElement.lang ||= "en";
    document.getElementById("root")?.setAttribute("role", "main");
    const canvas = window.__viserMutable?.canvas;
    if (canvas && !canvas.hasAttribute("role")) canvas.setAttribute("role", "img");
    name(canvas, "The robot on its floor");
  }

  function nameAll() {
    nameParts();
    reachScrolling();
    nameSliders();
    nameFields();
    nameIcons();
    openFolders();
  }

  window.llsrbm.layout.onChange(nameAll);
})();
