// The bar under the picture: phases, marks, time; drag to scrub. Keys: space, arrows, Home, End.
(() => {
  const { page, player, element, addToPage, listenToKeys } = window.llsrbm;
  const SPEEDS = [0.1, 0.25, 0.5, 1];
  const WRITTEN_EVERY = 100; // ms; numbers that change faster cannot be read
  const LABEL_LINES = 2, LABEL_HEIGHT = 13, BETWEEN = 4; // lines above the strips; pixels
  const FAR = 6; // frames that an arrow key moves with Shift
  const EMPTY = "no motion yet";

  const STYLE = `
    #llsrbm-transport { position: fixed; z-index: 5; box-sizing: border-box;
      padding: 6px 10px 8px; font: 12px system-ui, sans-serif; user-select: none;
      color: var(--mantine-color-text); background: var(--mantine-color-body);
      border-top: 1px solid var(--mantine-color-default-border); touch-action: none; }
    #llsrbm-transport .line { display: flex; flex-wrap: wrap; gap: 2px 8px; align-items: center; }
    #llsrbm-transport :is(button, select) { min-height: 26px; min-width: 32px; cursor: pointer; }
    #llsrbm-transport button[aria-pressed=true] { background: var(--mantine-primary-color-light); }
    #llsrbm-transport .time { font-variant-numeric: tabular-nums; min-width: 8.5em; }
    #llsrbm-transport .events { opacity: 0.75; flex: 1; min-width: 12em; white-space: nowrap;
      overflow: hidden; text-overflow: ellipsis; }
    #llsrbm-transport .track { position: relative; margin-top: 4px; padding-top: 27px;
      cursor: ew-resize; }
    #llsrbm-transport .row { position: relative; height: 14px; margin-bottom: 2px;
      border-radius: 3px; overflow: hidden; background: var(--mantine-color-default); }
    #llsrbm-transport .row > div { position: absolute; top: 0; bottom: 0; box-sizing: border-box;
      padding: 0 2px; font-size: 10px; line-height: 14px; color: #14181c; white-space: pre;
      display: flex; overflow: hidden; }
    #llsrbm-transport .phase > span { overflow: hidden; text-overflow: ellipsis; min-width: 0; }
    #llsrbm-transport .phase > .feet { flex-shrink: 1000; } /* where it is narrow, the name stays */
    #llsrbm-transport .row > .low { top: 10px; }
    #llsrbm-transport .row.bars { height: 22px; }
    #llsrbm-transport .row.bars > .bar { top: auto; padding: 0; width: 4px; margin-left: -2px;
      background: #d6336c; }
    #llsrbm-transport .row.bars > .bar.in-time { background: #2f9e62; }
    #llsrbm-transport .row.bars > .deadline { left: 0; right: 0; top: 50%; padding: 0; bottom: auto;
      border-top: 1px dashed currentColor; color: var(--mantine-color-text); opacity: 0.6; }
    #llsrbm-transport .mark { position: absolute; top: 0; bottom: 0; width: 2px; margin-left: -1px;
      background: color-mix(in srgb, currentColor 75%, transparent); pointer-events: none; }
    #llsrbm-transport .mark span { position: absolute; top: 0; left: 4px; font-size: 10px;
      line-height: 12px; white-space: nowrap;
      color: color-mix(in srgb, currentColor 50%, var(--mantine-color-text)); }
    #llsrbm-transport .mark.left span { left: auto; right: 4px; }
    #llsrbm-transport .cursor { position: absolute; top: 24px; bottom: -3px; left: 0; width: 100%;
      pointer-events: none; will-change: transform; }
    #llsrbm-transport .cursor::before { content: ""; position: absolute; left: -1.5px; top: 0;
      bottom: 0; width: 3px; background: var(--mantine-color-text); border-radius: 2px; }`;

  const button = (label, key, sign, onclick) => element("button",
    { type: "button", "aria-label": label, title: key ? `${label} (${key})` : label, onclick }, sign);

  const play = button("Play", "space", "▶", () => player.play());
  const pause = button("Pause", "space", "❚❚", () => player.pause());
  const back = button("One frame back", "left arrow", "◂|", () => player.step(-1));
  const forth = button("One frame on", "right arrow", "|▸", () => player.step(1));
  const repeat = button("Loop", "", "⟲", () => choose({ loop: !player.loop }));
  const rate = element("select", { "aria-label": "Speed", title: "Seconds of motion a second" },
    ...SPEEDS.map((speed) => element("option", { value: speed }, `${speed}×`)));
  rate.addEventListener("change", () => choose({ speed: Number(rate.value) }));
  const clock = element("span", { class: "time" }, EMPTY);
  const events = element("span", { class: "events" });
  const rows = element("div");
  const cursor = element("div", { class: "cursor" });
  const track = element("div", { class: "track", role: "group", "aria-label": "Timeline" });
  const bar = element("div", { id: "llsrbm-transport", role: "region", "aria-label": "Playback" },
    element("div", { class: "line" },
      back, play, pause, forth, clock, rate, repeat, events), track);

  let written = -Infinity;
  let shown = null; // llsrbm/look/timeline.py, `Timeline`

  function choose({ loop = player.loop, speed = player.speed }) {
    player.setLoop(loop);
    player.setSpeed(speed);
    page.send({ kind: "playback", loop, speed });
  }

  function show(timeline) {
    shown = timeline;
    const share = (time) => `${(100 * time) / Math.max(timeline.end, 1e-6)}%`;
    rows.replaceChildren(...timeline.rows.map(({ name, pieces }) => {
      const row = element("div", { class: "row", title: name });
      for (const { start, end, colour, name: phase, low, feet } of pieces) {
        const title = `${name}: ${phase}${feet ? ` (standing: ${feet})` : ""}`;
        const label = low ? [] : [element("span", {}, phase)];
        if (feet) label.push(element("span", { class: "feet" }, ` · ${feet}`));
        const piece = element("div", { title, class: low ? "low" : "phase" }, ...label);
        Object.assign(piece.style, {
          left: share(start), width: share(end - start), background: colour,
        });
        row.append(piece);
      }
      return row;
    }), ...computing(timeline.bars, share));
    const marks = timeline.marks.map(({ time, name, colour }) => {
      const left = time > 0.8 * timeline.end;
      const mark = element("div", { class: left ? "mark left" : "mark", title: name },
        element("span", {}, name));
      Object.assign(mark.style, { left: share(time), color: colour });
      return mark;
    });
    track.replaceChildren(rows, ...marks, cursor);
    events.textContent = events.title = timeline.summary;
    placeLabels(marks);
    refresh();
  }

  // A strip of the times that planning anew took; its middle is the deadline.
  function computing(bars, share) {
    if (!bars.length) return [];
    const strip = element("div", { class: "row bars", role: "img",
      "aria-label": `computing times of ${bars.length} new plans, ` +
        `${bars.filter((bar) => bar.in_time).length} in time` });
    for (const { time, height, in_time: inTime, words } of bars) {
      const bar = element("div", { class: inTime ? "bar in-time" : "bar", title: words });
      Object.assign(bar.style, { left: share(time), height: `${Math.min(50 * height, 100)}%` });
      strip.append(bar);
    }
    strip.append(element("div", { class: "deadline" }));
    return [strip];
  }

  // Each label in the first line where it lies over no other one; where there is none, the mark's
  // title has to do.
  function placeLabels(marks) {
    const lines = Array.from({ length: LABEL_LINES }, () => []);
    for (const mark of marks) {
      const label = mark.firstChild;
      const { left, right } = label.getBoundingClientRect();
      const free = lines.findIndex((line) =>
        line.every((other) => left > other.right + BETWEEN || other.left > right + BETWEEN));
      label.style.visibility = free < 0 ? "hidden" : "visible";
      if (free < 0) continue;
      lines[free].push({ left, right });
      label.style.top = `${LABEL_HEIGHT * free}px`;
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
    play.setAttribute("aria-pressed", player.playing);
    pause.setAttribute("aria-pressed", !player.playing);
    if (repeat.getAttribute("aria-pressed") !== String(player.loop))
      repeat.setAttribute("aria-pressed", player.loop);
    if (rate.value !== String(player.speed)) rate.value = String(player.speed);
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
    if (!canvas) return;
    const box = canvas.getBoundingClientRect();
    Object.assign(bar.style, {
      left: `${box.left}px`, width: `${box.width}px`,
      bottom: `${Math.max(0, window.innerHeight - box.bottom)}px`,
    });
  }

  const far = (event) => (event.shiftKey ? FAR : 1);
  listenToKeys({
    " ": () => player.toggle(),
    ArrowLeft: (event) => player.step(-far(event)),
    ArrowRight: (event) => player.step(far(event)),
    Home: () => player.seek(0),
    End: () => player.seek(Infinity),
  }, () => player.clip);
  window.addEventListener("resize", () => shown && placeLabels([...track.querySelectorAll(".mark")]));
  addToPage(STYLE, bar);
  setInterval(follow, 250);
  player.listen(refresh);

  window.llsrbm.transport = {
    show(timeline) {
      show(timeline);
      follow();
    },
    clear() {
      shown = null;
      rows.replaceChildren();
      track.replaceChildren(rows);
      events.textContent = "";
      write(clock, EMPTY);
    },
  };
})();
