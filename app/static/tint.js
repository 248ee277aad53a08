// The sliders' tracks: solid where the jump can be planned with the other values as they are, dashes
// where not. The server says which slider and how likely (app/tab/planning/feasible.py); dashes need
// no colour.
(() => {
  const TINTED = "data-llsrbm-tinted", TINT = "--llsrbm-tint";
  const DASHES = "repeating-linear-gradient(90deg, var(--llsrbm-cannot) 0 2px, transparent 2px 6px)";
  window.llsrbm.addToPage(`
    :root { --llsrbm-can: #3a86c8; --llsrbm-cannot: #8b9199; }
    :root[data-mantine-color-scheme=dark] { --llsrbm-can: #5aa2e0; --llsrbm-cannot: #8b939e; }
    [${TINTED}] .mantine-Slider-bar { background: transparent; }
    [${TINTED}] .mantine-Slider-track::before { opacity: 1; background: var(${TINT}), ${DASHES}; }`);

  let tracks = {};

  // Stops of a gradient: of chances in per cent, evenly spread, those that are not between alike ones.
  function stops(chances) {
    return chances.flatMap((chance, k) => {
      if (k > 0 && chances[k - 1] === chance && chances[k + 1] === chance) return [];
      const place = (100 * k) / (chances.length - 1);
      return `color-mix(in srgb, var(--llsrbm-can) ${chance}%, transparent) ${place.toFixed(1)}%`;
    }).join();
  }

  // The style of one element: a style sheet would have the browser look at the whole page.
  function draw() {
    for (const [uuid, { chances, text }] of Object.entries(tracks)) {
      const slider = document.getElementById(uuid);
      if (!slider || slider.llsrbmTrack === tracks[uuid]) continue;
      slider.llsrbmTrack = tracks[uuid];
      slider.toggleAttribute(TINTED, chances.length > 0);
      slider.style.setProperty(TINT, `linear-gradient(90deg, ${stops(chances)})`);
      slider.title = text; // for a pointer, and for a screen reader
      slider.querySelector("[role=slider]")?.setAttribute("aria-description", text);
    }
  }

  window.llsrbm.layout.onChange(draw); // viser makes its elements anew now and then

  window.llsrbm.tint = {
    show(shown) {
      tracks = shown;
      draw();
    },
  };
})();
