"""What cannot be read on a page: cut, covered, small, crowded or pale text; bars to the side."""

SMALLEST = 12  # px of letters
LEAST_CONTRAST = 4.5  # to 1, of letters that are not large
LARGE, LARGE_BOLD, LEAST_OF_LARGE = 24, 18.66, 3.0  # px, and their contrast (WCAG 2.1, 1.4.3)

UNREADABLE = """([smallest, least, large, largeBold, leastLarge]) => {
  const findings = [], say = (element, why) => findings.push(
    `${why}: ${element.tagName.toLowerCase()}${element.id ? "#" + element.id.slice(0, 20) : ""} `
    + `"${(element.textContent || element.value || "").trim().slice(0, 50)}"`);

  // Colours as a browser computes them, through a canvas: whatever notation they have.
  const probe = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  const known = new Map();
  function rgba(colour) {
    if (known.has(colour)) return known.get(colour);
    probe.clearRect(0, 0, 1, 1);
    probe.fillStyle = colour;
    probe.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = probe.getImageData(0, 0, 1, 1).data;
    known.set(colour, [r, g, b, a / 255]);
    return known.get(colour);
  }
  const over = (top, below) => top.slice(0, 3).map((c, i) => top[3] * c + (1 - top[3]) * below[i]);
  const light = (colour) => colour.map((c) => c / 255)
    .map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4))
    .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
  // null: there is a picture behind it.
  function behind(element) {
    const layers = [], place = element.getBoundingClientRect();
    const [x, y] = [place.left + place.width / 2, place.top + place.height / 2];
    for (let at = element; at; at = at.parentElement) {
      const style = getComputedStyle(at), box = at.getBoundingClientRect();
      if (x < box.left || x > box.right || y < box.top || y > box.bottom) continue;
      if (style.backgroundImage !== "none" && !at.matches("[role=tablist]")) return null;
      layers.push(rgba(style.backgroundColor));
      if (layers.at(-1)[3] === 1) break;
    }
    return layers.reverse().reduce((below, top) => over(top, below), [255, 255, 255]);
  }

  const seen = (element) => {
    const box = element.getBoundingClientRect(), style = getComputedStyle(element);
    if (box.width < 2 || box.height < 2 || style.visibility !== "visible") return null;
    for (let at = element; at; at = at.parentElement) {
      const { opacity, clipPath } = getComputedStyle(at);
      if (Number(opacity) === 0 || clipPath === "inset(50%)") return null;
    }
    return box;
  };

  const texts = [];
  for (const element of document.body.querySelectorAll("*")) {
    const own = [...element.childNodes].some((node) => node.nodeType === 3 && node.data.trim());
    const style = getComputedStyle(element);
    if (/auto|scroll/.test(style.overflowX) && element.clientWidth > 0
      && element.scrollWidth > element.clientWidth + 1) say(element, "scrolls to the side");
    if (!own && !element.matches("input:not([type=checkbox]):not([type=hidden]), select")) continue;
    if (element.matches("script, style, title, option, svg *, svg")) continue;
    const box = seen(element);
    if (!box) continue;
    const size = parseFloat(style.fontSize);
    if (size < smallest) say(element, `letters of ${size} px`);
    if (parseFloat(style.letterSpacing) < 0) say(element, `letters ${style.letterSpacing} apart`);
    const row = element.matches("input") && element.closest(".mantine-Flex-root");
    const beyond = row && row.clientWidth ? box.right - row.getBoundingClientRect().right : 0;
    if (beyond > 1) say(element, `${Math.round(beyond)} px beyond its row`);
    if (/hidden|clip/.test(style.overflowX) && element.scrollWidth > element.clientWidth + 1
      || element.matches("input") && element.scrollWidth > element.clientWidth + 1)
      say(element, `${element.scrollWidth} px in ${element.clientWidth}`);
    if (/hidden|clip/.test(style.overflowY) && element.scrollHeight > element.clientHeight + 2
      && !element.matches("input, select, span"))
      say(element, `${element.scrollHeight} px high in ${element.clientHeight}`);
    const disabled = element.closest("[data-disabled], :disabled, [aria-disabled=true]");
    const middle = [box.left + box.width / 2, box.top + box.height / 2];
    const onTop = document.elementsFromPoint(...middle).includes(element); // not scrolled away
    const ground = disabled || !onTop ? null : behind(element);
    if (ground) {
      const letters = over(rgba(style.color), ground);
      const [a, b] = [light(letters), light(ground)];
      const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
      const isLarge = size >= large || size >= largeBold && Number(style.fontWeight) >= 700;
      if (contrast < (isLarge ? leastLarge : least) - 0.01)
        say(element, `contrast ${contrast.toFixed(2)}`);
    }
    if (own) {
      const letters = document.createRange();
      letters.selectNodeContents(element);
      const { right } = letters.getBoundingClientRect();
      for (let at = element; at; at = at.parentElement) {
        const { overflowX, textOverflow } = getComputedStyle(at);
        if (textOverflow === "ellipsis") break;
        if (/hidden|clip/.test(overflowX) && right > at.getBoundingClientRect().right + 2) {
          say(element, `cut by ${Math.round(right - at.getBoundingClientRect().right)} px`);
          break;
        }
      }
      texts.push([element, box]);
    }
  }

  // Two texts in the panel or over the picture that lie on each other.
  const inside = (one, other) => one.contains(other) || other.contains(one);
  for (let i = 0; i < texts.length; i++) for (let k = i + 1; k < texts.length; k++) {
    const [[one, a], [other, b]] = [texts[i], texts[k]];
    const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left);
    const high = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
    if (wide <= 3 || high <= 3 || inside(one, other)) continue;
    const [x, y] = [Math.max(a.left, b.left) + wide / 2, Math.max(a.top, b.top) + high / 2];
    const there = document.elementsFromPoint(x, y);
    const depths = [there.indexOf(one), there.indexOf(other)].sort((p, q) => p - q);
    const covered = there.slice(...depths)
      .some((each) => rgba(getComputedStyle(each).backgroundColor)[3] > 0.9);
    if (depths[0] >= 0 && !covered) say(one, `lies on "${other.textContent.trim().slice(0, 30)}"`);
  }
  return [...new Set(findings)];
}"""


def unreadable(page):
    """Sentences on what cannot be read at the page's size, each once."""
    return page.evaluate(UNREADABLE, [SMALLEST, LEAST_CONTRAST, LARGE, LARGE_BOLD, LEAST_OF_LARGE])
