// Number boxes take numbers: what is none leaves the number as it is, and a note says what is accepted.
// A box that is left without one has its last number again.
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

  // ---- a box that is left empty, or with a sign alone, has its last number again

  const numbers = new WeakMap(); // box -> the last number that stood in it
  const isNumber = (box) => box.value.trim() !== "" && Number.isFinite(Number(box.value.replace(",", ".")));
  const setValue = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;

  function put(box, value) {
    setValue.call(box, value); // as React sees it
    box.dispatchEvent(new Event("input", { bubbles: true }));
  }

  function remember({ target }) {
    if (target instanceof Element && target.matches(BOXES) && isNumber(target))
      numbers.set(target, target.value.replace(/^-(?=[0.,]*$)/, "")); // no −0
  }

  function complete({ type, key, target }) {
    if (type === "keydown" && key !== "Enter") return;
    if (!(target instanceof Element) || !target.matches(BOXES) || isNumber(target)) return;
    if (!numbers.has(target)) return;
    put(target, numbers.get(target));
    window.llsrbm.tips.show(target, accepted(target));
  }

  for (const type of ["focusin", "input"]) document.addEventListener(type, remember, true);
  for (const type of ["focusout", "keydown"]) document.addEventListener(type, complete, true);
})();
