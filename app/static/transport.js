// The bar under the picture: phases, marks, time; drag to scrub. Keys: space, arrows, Home, End.
(() => {
  const { player } = window.llsrbm;
  const SPEEDS = [0.1, 0.25, 0.5, 1];
  const WRITTEN_EVERY = 100; // ms; numbers that change faster cannot be read
  const FAR = 6; // frames that an arrow key moves with Shift
  const TYPED_INTO = "input, textarea, select, [contenteditable], [role=slider], [role=textbox]";

  const STYLE = `
    #llsrbm-transport { position: fixed; z-index: 5; display: none; box-sizing: border-box;
      padding: 6px 10px 8px; font: 12px system-ui, sans-serif; user-select: none;
      color: var(--mantine-color-text); background: var(--mantine-color-body);
      border-top: 1px solid var(--mantine-color-default-border); touch-action: none; }
    #llsrbm-transport .line { display: flex; flex-wrap: wrap; gap: 2px 8px; align-items: center; }
    #llsrbm-transport button, #llsrbm-transport select { font: inherit; color: inherit;
      background: var(--mantine-color-default); border-radius: 4px; min-height: 26px;
      border: 1px solid var(--mantine-color-default-border); min-width: 32px; cursor: pointer; }
    #llsrbm-transport button[aria-pressed=true] { background: var(--mantine-primary-color-light); }
    #llsrbm-transport .time { font-variant-numeric: tabular-nums; min-width: 8.5em; }
    #llsrbm-transport .events { opacity: 0.75; flex: 1; min-width: 12em; white-space: nowrap;
      overflow: hidden; text-overflow: ellipsis; }
    #llsrbm-transport .track { position: relative; margin-top: 6px; padding-top: 13px;
      cursor: ew-resize; }
    #llsrbm-transport .row { position: relative; height: 10px; margin-bottom: 2px;
      border-radius: 3px; overflow: hidden; background: var(--mantine-color-default); }
    #llsrbm-transport .row > div { position: absolute; top: 0; bottom: 0; }
    #llsrbm-transport .mark { position: absolute; top: 0; bottom: 0; width: 2px; margin-left: -1px;
      background: currentColor; opacity: 0.75; pointer-events: none; }
    #llsrbm-transport .mark span { position: absolute; top: 0; left: 4px; font-size: 10px;
      line-height: 12px; white-space: nowrap; }
    #llsrbm-transport .mark.left span { left: auto; right: 4px; }
    #llsrbm-transport .cursor { position: absolute; top: 10px; bottom: -3px; left: 0; width: 100%;
      pointer-events: none; will-change: transform; }
    #llsrbm-transport .cursor::before { content: ""; position: absolute; left: -1.5px; top: 0;
      bottom: 0; width: 3px; background: var(--mantine-color-text); border-radius: 2px; }`;

  function element(kind, attributes = {}, ...children) {
    const made = document.createElement(kind);
    for (const [name, value] of Object.entries(attributes)) {
      if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
      else made.setAttribute(name, value);
    }
    made.append(...children);
    return made;
  }

  const button = (label, sign, onclick) =>
    element("button", { type: "button", "aria-label": label, title: label, onclick }, sign);

  const toggle = button("Toggle motion (space)", "", () => player.toggle());
  const back = button("One frame back (left arrow)", "◂|", () => player.step(-1));
  const forth = button("One frame on (right arrow)", "|▸", () => player.step(1));
  const repeat = button("Repeat", "⟲", () => choose({ loop: !player.loop }));
  const pace = element("select", { "aria-label": "Pace", title: "Seconds of motion a second" },
    ...SPEEDS.map((speed) => element("option", { value: speed }, `${speed}×`)));
  pace.addEventListener("change", () => choose({ speed: Number(pace.value) }));
  const clock = element("span", { class: "time" });
  const events = element("span", { class: "events" });
  const rows = element("div");
  const cursor = element("div", { class: "cursor" });
  const track = element("div", { class: "track", role: "group", "aria-label": "Timeline" });
  const bar = element("div", { id: "llsrbm-transport" },
    element("div", { class: "line" }, back, toggle, forth, clock, pace, repeat, events), track);

  let written = -Infinity;
  let shown = null; // llsrbm/motion/timeline.py, `Timeline`

  function choose({ loop = player.loop, speed = player.speed }) {
    player.setLoop(loop);
    player.setSpeed(speed);
    player.send({ kind: "pace", loop, speed });
  }

  function show(timeline) {
    shown = timeline;
    const share = (time) => `${(100 * time) / Math.max(timeline.end, 1e-6)}%`;
    rows.replaceChildren(...timeline.rows.map(({ name, pieces }) => {
      const row = element("div", { class: "row", title: name });
      for (const { start, end, colour, name: phase, low } of pieces) {
        const piece = element("div", { title: `${name}: ${phase}` });
        Object.assign(piece.style, {
          left: share(start), width: share(end - start), background: colour, top: low ? "50%" : 0,
        });
        row.append(piece);
      }
      return row;
    }));
    const marks = timeline.marks.map(({ time, name, colour }) => {
      const left = time > 0.8 * timeline.end;
      const mark = element("div", { class: left ? "mark left" : "mark", title: name },
        element("span", {}, name));
      Object.assign(mark.style, { left: share(time), color: colour });
      return mark;
    });
    track.replaceChildren(rows, ...marks, cursor);
    events.textContent = events.title = timeline.told;
    bar.style.display = "block";
    hideCrowded(marks);
    refresh();
  }

  // Of labels that would lie over each other, the earlier stays; each has its title.
  function hideCrowded(marks) {
    const taken = [];
    for (const mark of marks) {
      const label = mark.firstChild;
      label.style.visibility = "visible";
      const box = label.getBoundingClientRect();
      const crowded = taken.some((other) => box.left < other.right + 4 && other.left < box.right + 4);
      if (crowded) label.style.visibility = "hidden";
      else taken.push(box);
    }
  }

  // On every frame: only what the browser can move without laying the bar out anew.
  function refresh() {
    if (!shown) return;
    cursor.style.transform =
      `translateX(${(100 * player.time) / Math.max(shown.end, 1e-6)}%)`;
    const now = performance.now();
    if (player.playing && now - written < WRITTEN_EVERY) return;
    written = now;
    write(toggle, player.playing ? "❚❚" : "▶");
    if (repeat.getAttribute("aria-pressed") !== String(player.loop))
      repeat.setAttribute("aria-pressed", player.loop);
    if (pace.value !== String(player.speed)) pace.value = String(player.speed);
    const phase = shown.rows.at(-1)?.pieces
      .find(({ start, end, low }) => !low && player.time >= start && player.time < end);
    write(clock, `${player.time.toFixed(2)} / ${shown.end.toFixed(2)} s ${phase ? phase.name : ""}`);
  }

  function write(place, text) {
    if (place.textContent !== text) place.textContent = text;
  }

  function scrub(event) {
    const box = track.getBoundingClientRect();
    player.pause();
    player.seek(((event.clientX - box.left) / box.width) * (shown?.end ?? 0));
  }
  track.addEventListener("pointerdown", (event) => {
    track.setPointerCapture(event.pointerId);
    scrub(event);
  });
  track.addEventListener("pointermove", (event) => {
    if (track.hasPointerCapture(event.pointerId)) scrub(event);
  });

  // Under the picture, however the panel is docked.
  function follow() {
    const canvas = window.__viserMutable?.canvas;
    if (!canvas || !shown) return;
    const box = canvas.getBoundingClientRect();
    Object.assign(bar.style, {
      left: `${box.left}px`, width: `${box.width}px`,
      bottom: `${Math.max(0, window.innerHeight - box.bottom)}px`,
    });
  }

  // Before viser sees them: it would turn the camera with the arrows.
  function press(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || !player.clip) return;
    if (event.target instanceof Element && event.target.closest(TYPED_INTO)) return;
    const far = event.shiftKey ? FAR : 1;
    const acts = {
      " ": () => player.toggle(),
      ArrowLeft: () => player.step(-far),
      ArrowRight: () => player.step(far),
      Home: () => player.seek(0),
      End: () => player.seek(Infinity),
    };
    const act = acts[event.key];
    if (!act) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    act();
  }

  window.addEventListener("keydown", press, { capture: true });
  // A focused button would be clicked by the space that has just toggled the motion.
  window.addEventListener("keyup", (event) => {
    const typing = event.target instanceof Element && event.target.closest(TYPED_INTO);
    if (event.key === " " && player.clip && !typing) event.preventDefault();
  }, { capture: true });
  window.addEventListener("resize", () => shown && hideCrowded([...track.querySelectorAll(".mark")]));
  document.addEventListener("DOMContentLoaded", () => {
    document.head.append(element("style", {}, STYLE));
    document.body.append(bar);
    setInterval(follow, 250);
  });
  player.listen(refresh);

  window.llsrbm.transport = {
    show(timeline) {
      show(timeline);
      follow();
    },
    hide() {
      shown = null;
      bar.style.display = "none";
    },
  };
})();
