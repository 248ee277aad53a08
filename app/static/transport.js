// The bar under the picture: play and pause, speed, and the timeline (timeline.js). Keys: space,
// arrows, Home, End.
(() => {
  const { page, player, timeline, layout, element, write, addToPage, listenToKeys } = window.llsrbm;
  const SPEEDS = [0.1, 0.25, 0.5, 1];
  const WRITTEN_EVERY = 100; // ms; numbers that change faster cannot be read
  const FAR = 6; // frames that an arrow key moves with Shift
  const EMPTY = "no motion yet";

  const STYLE = `
    #llsrbm-transport { left: 0; right: 0; bottom: 0; padding: 6px 10px 8px; font: 12px system-ui, sans-serif; user-select: none;
      color: var(--mantine-color-text); background: var(--mantine-color-body);
      border-top: 1px solid var(--mantine-color-default-border); touch-action: none; }
    #llsrbm-transport .line { display: flex; flex-wrap: wrap; gap: 2px 8px; align-items: center; }
    #llsrbm-transport :is(button, select) { min-height: 26px; min-width: 32px; cursor: pointer; }
    /* Steps are of a motion that stands; a pointer or the keys bring all there is. */
    @media (hover: hover) {
      #llsrbm-transport.plays:not(:hover, :focus-within) .rare { opacity: 0; } }
    #llsrbm-transport button[aria-pressed=true] { background: var(--mantine-primary-color-light); }
    #llsrbm-transport .time { font-variant-numeric: tabular-nums; min-width: 8.5em; }
    #llsrbm-transport .events { opacity: 0.75; flex: 1; min-width: 12em; white-space: nowrap;
      overflow: hidden; text-overflow: ellipsis; }
    @media (max-width: 640px) { /* the timeline has the events; fingers scrub */
      #llsrbm-transport :is(.events, .step, .handle.rare) { display: none; } }`;

  const button = (label, key, sign, onclick) => element("button",
    { type: "button", "aria-label": label, title: key ? `${label} (${key})` : label, onclick }, sign);

  const play = button("Play", "space", "▶", () => player.toggle());
  const back = button("One frame back", "left arrow", "◂|", () => player.step(-1));
  const forth = button("One frame on", "right arrow", "|▸", () => player.step(1));
  const repeat = button("Loop", "", "⟲", () => choose({ loop: !player.loop }));
  const zoom = button("Zoom", "", "⤢", () => timeline.toggleZoom());
  zoom.title = "Zoom to the range that is looped, or to what is near the cursor; or turn the wheel";
  const rate = element("select", { "aria-label": "Speed", title: "Seconds of motion a second" },
    ...SPEEDS.map((speed) => element("option", { value: speed }, `${speed}×`)));
  for (const rare of [back, forth, rate, repeat, zoom]) rare.classList.add("rare");
  for (const step of [back, forth, zoom]) step.classList.add("step");
  rate.addEventListener("change", () => choose({ speed: Number(rate.value) }));
  const clock = element("span", { class: "time" }, EMPTY);
  const events = element("span", { class: "events" });
  const bar = element("div", { id: "llsrbm-transport", role: "region", "aria-label": "Playback" },
    element("div", { class: "line" },
      back, play, forth, clock, rate, repeat, zoom, events), timeline.element);

  let written = -Infinity;
  let shown = null; // llsrbm/look/timeline.py, `Timeline`

  function choose({ loop = player.loop, speed = player.speed }) {
    player.setLoop(loop);
    player.setSpeed(speed);
    page.send({ kind: "playback", loop, speed });
  }

  function show(next) {
    shown = next;
    events.textContent = events.title = next.summary;
    timeline.show(next);
    refresh();
  }

  // On every frame.
  function refresh() {
    if (!shown) return;
    timeline.refresh();
    const label = player.playing ? "Pause" : "Play";
    if (play.getAttribute("aria-label") !== label) {
      bar.classList.toggle("plays", player.playing);
      play.setAttribute("aria-label", label);
      play.title = `${label} (space)`;
      write(play, player.playing ? "❚❚" : "▶");
    }
    const now = performance.now();
    if (player.playing && now - written < WRITTEN_EVERY) return;
    written = now;
    if (repeat.getAttribute("aria-pressed") !== String(player.loop))
      repeat.setAttribute("aria-pressed", player.loop);
    if (rate.value !== String(player.speed)) rate.value = String(player.speed);
    const phase = shown.rows.at(-1)?.pieces
      .find(({ start, end, low }) => !low && player.time >= start && player.time < end);
    write(clock, `${player.time.toFixed(2)} / ${shown.end.toFixed(2)} s ${phase ? phase.name : ""}`);
  }

  const far = (event) => (event.shiftKey ? FAR : 1);
  listenToKeys({
    " ": () => player.toggle(),
    ArrowLeft: (event) => player.step(-far(event)),
    ArrowRight: (event) => player.step(far(event)),
    Home: () => player.seek(0),
    End: () => player.seek(Infinity),
  }, () => player.clip);
  timeline.onChange(() => zoom.setAttribute("aria-pressed", timeline.zoomed));
  addToPage(STYLE + timeline.style);
  layout.over.append(bar);
  layout.watch(bar); // the camera shows what it leaves free
  player.listen(refresh);

  window.llsrbm.transport = {
    show,
    clear() {
      shown = null;
      timeline.clear();
      write(events, "");
      write(clock, EMPTY);
    },
  };
})();
