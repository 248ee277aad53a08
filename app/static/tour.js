// The first minute: a welcome that says what the page is, with the first example, and four cards that
// point at what matters, once for each browser. It can be skipped with a click or Escape, and the
// cards opened again by `llsrbm.tour.start()` (help.js).
(() => {
  const { page, layout, element, addToPage } = window.llsrbm;
  const SEEN = "llsrbm.tour"; // name in the browser's storage
  const AWAY = 12; // pixels between a card and what it points at

  const STEPS = [
    {
      title: "Design a jump; see why inertia matters", at: () => null,
      text: "A legged robot's jump is planned within the limits of its drives while you move a " +
        "slider, and the whole robot follows the plan in a simulation.",
    },
    {
      title: "Move a slider", at: () => control("Twist [deg]"),
      text: "The jump is planned while you drag, and the robot replays it at once.",
    },
    {
      title: "Read the ellipsoid", at: () => null,
      text: "It is the uniform solid ellipsoid with the robot's mass and inertia. The narrower it " +
        "is, the faster the robot turns; legs that swing meanwhile take a part of the turn.",
    },
    {
      title: "Simulate", at: () => button("Simulate"),
      text: "The whole robot follows the plan in MuJoCo; the plan stays beside it as a ghost.",
    },
    {
      title: "Take it along", at: () => button("Export…"),
      text: "Export the motion for your own tools, share the design as a link, or open a file " +
        "by dropping it on the page.",
    },
  ];

  const STYLE = `
    #llsrbm-tour { position: fixed; z-index: 500; display: none; width: 17rem; box-sizing: border-box;
      padding: 0.8rem 1rem; border-radius: 8px; font: 14px/1.45 system-ui, sans-serif;
      color: var(--mantine-color-text); background: var(--mantine-color-body);
      border: 1px solid var(--mantine-color-default-border);
      box-shadow: 0 6px 24px rgba(0, 0, 0, 0.22); }
    #llsrbm-tour h2 { margin: 0 0 0.2rem; font-size: 1rem; }
    #llsrbm-tour p { margin: 0 0 0.6rem; }
    #llsrbm-tour .example button { display: grid; width: 100%; margin: 0 0 0.6rem; padding: 0 0 0.3rem;
      text-align: left; overflow: hidden; }
    #llsrbm-tour .picture { width: 100%; height: 7.5rem; object-fit: cover; background: #dde4ea; }
    #llsrbm-tour :is(b, .example span) { padding: 0.1rem 0.6rem; }
    #llsrbm-tour .line { display: flex; gap: 0.5rem; align-items: center; }
    #llsrbm-tour .line span { flex: 1; opacity: 0.75; }
    #llsrbm-tour button { padding: 0.2rem 0.8rem; }
    @media (max-width: 640px) { /* across a phone, on its panel */
      #llsrbm-tour { width: calc(100vw - ${2 * AWAY}px); }
      #llsrbm-tour .example button { grid-template-columns: 7rem 1fr; }
      #llsrbm-tour .picture { grid-row: 1 / span 2; height: 100%; } }
    .llsrbm-pointed { outline: 2px solid var(--mantine-primary-color-filled); outline-offset: 3px;
      border-radius: 4px; }`;

  const control = (label) => [...document.querySelectorAll("label")]
    .find((each) => each.textContent.trim() === label)?.closest(".mantine-Flex-root") ?? null;
  const button = (label) => [...document.querySelectorAll("button")]
    .find((each) => each.textContent.trim() === label) ?? null;

  const title = element("h2", { id: "llsrbm-tour-title" });
  const example = element("div", { class: "example" });
  const text = element("p");
  const count = element("span");
  const skip = element("button", { type: "button", onclick: end }, "Skip");
  const next = element("button", { type: "button", onclick: () => show(at + 1) }, "Next");
  const card = element("div",
    { id: "llsrbm-tour", role: "dialog", "aria-labelledby": "llsrbm-tour-title", "aria-live": "polite" },
    title, text, example, element("div", { class: "line" }, count, skip, next));

  let at = -1, pointed = null;

  function seen() {
    try {
      return localStorage.getItem(SEEN) !== null;
    } catch {
      return true; // a browser that keeps nothing would see it every time
    }
  }

  function end() {
    at = -1;
    card.style.display = "none";
    pointed?.classList.remove("llsrbm-pointed");
    pointed = null;
    try {
      localStorage.setItem(SEEN, "seen");
    } catch { /* it keeps nothing */ }
  }

  function show(index) {
    if (index >= STEPS.length) return end();
    at = index;
    const step = STEPS[index];
    title.textContent = step.title;
    text.textContent = step.text;
    count.textContent = index ? `${index} of ${STEPS.length - 1}` : "";
    next.textContent = !index ? "Tour" : index + 1 < STEPS.length ? "Next" : "Done";
    example.style.display = index ? "none" : "";
    skip.style.display = index + 1 < STEPS.length ? "" : "none";
    pointed?.classList.remove("llsrbm-pointed");
    pointed = step.at();
    pointed?.classList.add("llsrbm-pointed");
    card.style.display = "block";
    place();
  }

  // Beside what it points at, towards the picture; else in the picture's lower corner.
  function place() {
    if (at < 0) return;
    const { width, height } = card.getBoundingClientRect();
    const bar = document.getElementById("llsrbm-transport")?.getBoundingClientRect();
    const corner = { left: AWAY, top: (window.llsrbm.sheet.height ? innerHeight : bar?.top ?? innerHeight) - height - AWAY };
    const box = pointed?.getBoundingClientRect();
    const beside = box && box.width > 0 && box.left > width + 2 * AWAY
      ? { left: box.left - width - AWAY, top: Math.max(AWAY, box.top + (box.height - height) / 2) }
      : corner;
    card.style.left = `${beside.left}px`;
    card.style.top = `${Math.max(0, Math.min(beside.top, window.innerHeight - height - AWAY))}px`;
  }

  window.addEventListener("resize", place);
  layout.onMove(place);
  window.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && at >= 0) end();
  });
  addToPage(STYLE, card);

  window.llsrbm.tour = {
    start: () => show(1),
    // When the first motion plays.
    offer() {
      if (at >= 0 || seen()) return;
      show(0);
      page.send({ kind: "cards" });
    },
    // The first example, in the welcome.
    invite(card) {
      card.addEventListener("click", end);
      example.replaceChildren(card);
      place();
    },
  };
})();
