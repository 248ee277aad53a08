// The sliders' tracks: solid where the jump can be planned with the other values as they are, dashes
// where not, plain where nothing is known. The server says which slider and how likely (app/tab/planning/feasible.py); dashes need
// no colour.
(() => {
  const TINTED = "data-llsrbm-tinted", TINT = "--llsrbm-tint";
  const DASHES = "repeating-linear-gradient(90deg, var(--llsrbm-cannot) 0 2px, transparent 2px 6px)";
  window.llsrbm.addToPage(`
    :root { --llsrbm-unknown: var(--mantine-color-gray-3); --llsrbm-can: #3a86c8; --llsrbm-cannot: #8b9199; --llsrbm-range: #1f65a3; }
    :root[data-mantine-color-scheme=dark] { --llsrbm-unknown: var(--mantine-color-dark-4); --llsrbm-can: #5aa2e0; --llsrbm-cannot: #8b939e;
      --llsrbm-range: #7fb9ec; }
    /* Between the slider's limits. */
    [data-llsrbm-range]::after { content: attr(data-llsrbm-range); position: absolute; left: 3.2em;
      right: 3.2em; top: 18px; text-align: center; white-space: nowrap; overflow: hidden;
      font-size: 12px; line-height: 1; color: var(--llsrbm-range); }
    [${TINTED}] .mantine-Slider-bar { background: transparent; }
    [${TINTED}] .mantine-Slider-track::before { opacity: 1; background: var(${TINT}), ${DASHES}; }`);

  let tracks = {};

  // Stops of a gradient: of chances in per cent, evenly spread, those that are not between alike ones.
  function stops(chances) {
    return chances.flatMap((chance, k) => {
      if (k > 0 && chances[k - 1] === chance && chances[k + 1] === chance) return [];
      const place = (100 * k) / (chances.length - 1);
      const colour = chance === null ? "var(--llsrbm-unknown)"
        : `color-mix(in srgb, var(--llsrbm-can) ${chance}%, transparent)`;
      return `${colour} ${place.toFixed(1)}%`;
    }).join();
  }

  // The style of one element: a style sheet would have the browser look at the whole page.
  function draw() {
    for (const [uuid, { chances, text, range }] of Object.entries(tracks)) {
      const slider = document.getElementById(uuid);
      if (!slider || slider.llsrbmTrack === tracks[uuid]) continue;
      slider.llsrbmTrack = tracks[uuid];
      slider.dataset.llsrbmRange = range;
      slider.toggleAttribute(TINTED, chances.length > 0);
      slider.style.setProperty(TINT, `linear-gradient(90deg, ${stops(chances)})`);
      slider.querySelector("[role=slider]")?.setAttribute("aria-description", text);
    }
  }

  window.llsrbm.layout.onChange(draw); // viser makes its elements anew now and then

  window.llsrbm.tint = {
    words: (uuid) => tracks[uuid]?.text ?? "", // on what can be planned (tips.js)
    show(shown) {
      tracks = shown;
      draw();
    },
  };
})();
