// The meaning of a control or a figure, in one note: at the pointer, or at the focus, on its label, its
// control and its numbers alike. The server says the words of each control (`set`); other elements
// have theirs in `data-tip`; sliders say what can be planned as well (tint.js).
(() => {
  const { layout, element, addToPage } = window.llsrbm;
  const ROW = ".mantine-Flex-root:has(label[for])", AFTER = 350, AWAY = 8; // ms; pixels

  const STYLE = `
    #llsrbm-tip { position: fixed; left: 0; top: 0; z-index: 400; display: none; pointer-events: none;
      max-width: min(19rem, 90vw); padding: 5px 9px; border-radius: 5px; white-space: pre-line;
      font: 13px/1.4 system-ui, sans-serif; color: var(--mantine-color-body);
      background: color-mix(in srgb, var(--mantine-color-text) 92%, transparent); }
    :is([data-tip], label[for]) { cursor: help; }`;

  const tip = element("div", { id: "llsrbm-tip", role: "tooltip" });
  let hints = {}, later = 0, of = null;

  function wordsOf(target) {
    const own = target.closest("[data-tip]");
    if (own) return [own, own.dataset.tip];
    const button = target.closest("button[id]"), row = button ? null : target.closest(ROW);
    const uuid = button?.id ?? row?.querySelector("label[for]").htmlFor;
    const can = row && window.llsrbm.tint?.words(uuid);
    const text = [hints[uuid]?.[1], can].filter(Boolean).join(".\n");
    return text ? [button ?? row, text] : [null, ""];
  }

  function show(at, text) {
    tip.textContent = text;
    tip.style.display = "block";
    const box = at.getBoundingClientRect(), { offsetWidth: wide, offsetHeight: high } = tip;
    // Above the timeline, beside the panel, where it hides no control; else below.
    const above = at.closest("#llsrbm-transport");
    const left = box.left - wide - AWAY, beside = left > 0 && !above;
    const top = above ? above.getBoundingClientRect().top - high - AWAY
      : beside ? box.top : box.bottom + AWAY;
    tip.style.left = `${beside ? left : Math.max(0, Math.min(box.left, innerWidth - wide))}px`;
    tip.style.top = `${Math.max(0, Math.min(top, innerHeight - high))}px`;
  }

  function hide() {
    clearTimeout(later);
    of = null;
    tip.style.display = "none";
  }

  // A thumb has its name as a title, which a browser would show as a second note: meanwhile the name
  // is a label.
  let untitled = null;
  function untitle(target) {
    if (untitled && untitled[0] !== target) {
      untitled[0].title = untitled[1];
      untitled[0].setAttribute("aria-label", "");
      untitled = null;
    }
    if (!target.matches("[role=slider].mantine-Slider-thumb[title]:not([title=''])")) return;
    untitled = [target, target.title];
    target.setAttribute("aria-label", target.title);
    target.title = "";
  }

  function look({ target, type }) {
    if (!(target instanceof Element)) return;
    untitle(target);
    const [at, text] = wordsOf(target);
    if (at === of) return;
    hide();
    if (!at) return;
    of = at;
    later = setTimeout(() => at.isConnected && !at.matches(".held") && show(at, text),
      type === "focusin" ? 0 : AFTER);
  }

  document.addEventListener("pointerover", look);
  document.addEventListener("focusin", (event) => {
    if (event.target.matches?.(":focus-visible")) look(event);
  });
  for (const kind of ["pointerdown", "focusout", "keydown", "wheel"])
    document.addEventListener(kind, hide, { capture: true, passive: true });

  // For a screen reader.
  function describe() {
    for (const [uuid, [, text]] of Object.entries(hints)) {
      const control = document.getElementById(uuid);
      if (!control?.hasAttribute("aria-description")) control?.setAttribute("aria-description", text);
    }
  }

  layout.onChange(describe);
  addToPage(STYLE, element("div", { role: "region", "aria-label": "Note" }, tip));

  window.llsrbm.tips = {
    get terms() { return Object.fromEntries(Object.values(hints)); }, // label -> meaning
    show, // a note until the next key or press
    set(words) {
      hints = words;
      describe();
    },
  };
})();
