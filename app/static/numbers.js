// Number boxes take numbers: what is none leaves the number as it is, and a note says what is accepted.
(() => {
  const BOXES = "input.mantine-NumberInput-input", ROW = ".mantine-Flex-root:has(label)";
  const OF_NUMBERS = /^[\d.,+\-−\s]*$/;

  function accepted(box) {
    const row = box.closest(ROW), thumb = row?.querySelector("[role=slider]");
    const label = row?.querySelector("label")?.textContent.trim();
    const [low, high] = [thumb?.ariaValueMin, thumb?.ariaValueMax]
      .map((end) => end?.replace("-", "−"));
    return `${label ?? "Here"}: expected a number${low && high ? ` from ${low} to ${high}` : ""}`;
  }

  document.addEventListener("beforeinput", (event) => {
    const box = event.target;
    if (!(box instanceof Element) || !box.matches(BOXES) || OF_NUMBERS.test(event.data ?? "")) return;
    event.preventDefault();
    window.llsrbm.tips.show(box, accepted(box));
  }, true);
})();
