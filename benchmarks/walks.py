"""Five walks of a new visitor through the page, measured: `python -m benchmarks.walks`.

At each size, by day and by night, a browser that has never been here comes in and plays, turns the
jump by its slider, compares the models, opens an example and exports it, pushes the robot, disturbs
it and edits the flight in the timeline; with `--keys` by the keyboard alone. At each stop the page
is photographed into `--out` and asked what of it cannot be read or lies on something else, and what
axe-core (`npm install axe-core` into that folder) finds, of every rule and impact. Printed are
these, the time to the first motion, the controls at first sight and labels without a description.
Exit status 1 if anything is found. `--url` takes a server that runs already.
"""

import argparse
import contextlib
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from playwright.sync_api import Browser, Error, Locator, Page

from benchmarks.page import FIRST_PICTURE
from benchmarks.served import serving, wait_until_ready
from tests.app.chromium import ON_DEMAND, PACE, chromium, looked_at, number, settled, status
from tests.app.legibility import unreadable

SIZES = ((1440, 900), (1280, 720), (1920, 1080), (390, 844))
PATIENCE = 180_000  # ms; a first start builds solvers
EXAMPLE = "ANYmal"  # in the title of the card that is chosen
MOST_CONTROLS, LATEST = 28, 3.0  # at first sight; s to the first motion
FARTHEST = 250  # presses of Tab to a control

# What can be pressed, moved or typed into, each once: a slider and its number are one control.
CONTROLS = """() => {
  const seen = (each) => {
    const { left, top, width, height } = each.getBoundingClientRect();
    const [x, y] = [left + width / 2, top + height / 2];
    if (Math.min(width, height) < 3) return false;
    for (let at = each; at; at = at.parentElement)
      if (Number(getComputedStyle(at).opacity) === 0) return false;
    return document.elementsFromPoint(x, y).includes(each);
  };
  const all = [...document.querySelectorAll(`button, input:not([type=hidden], [type=file]), select,
    summary, a[href], [role=button], [role=slider]:not(.mantine-Slider-thumb), [role=tab]`)]
    .filter((each) => !each.closest(".mantine-NumberInput-controls") && seen(each));
  const named = (each) => (each.ariaLabel || each.labels?.[0]?.textContent
    || each.innerText || each.title || "").trim();
  const covered = [];
  for (const each of all) {
    const { left, top, width, height } = each.getBoundingClientRect();
    const on = document.elementFromPoint(left + width / 2, top + height / 2);
    const label = each.labels?.[0];
    if (on.closest("#llsrbm-tour")) continue; // a dialog, until it is closed
    if (!each.contains(on) && !on.contains(each) && !on.closest("label, .mantine-Slider-root")
      && !(label && label.contains(on)) && each.parentElement !== on.parentElement)
      covered.push(`control "${named(each)}" lies under ${on.tagName} "${on.id || on.className}"`);
  }
  for (let i = 0; i < all.length; i++) for (let k = i + 1; k < all.length; k++) {
    const [a, b] = [all[i], all[k]], [p, q] = [a, b].map((each) => each.getBoundingClientRect());
    if (a.closest("#llsrbm-tour") !== b.closest("#llsrbm-tour")) continue;
    if (a.contains(b) || b.contains(a) || Math.min(p.right, q.right) - Math.max(p.left, q.left) <= 3
      || Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top) <= 3) continue;
    covered.push(`controls "${named(a)}" and "${named(b)}" overlap`);
  }
  const sideways = document.scrollingElement.scrollWidth - innerWidth;
  if (sideways > 0) covered.push(`the page is ${sideways} px too wide`);
  return [all.map(named), [...new Set(covered)]];
}"""
AXE = """async () => (await axe.run(document, { resultTypes: ["violations"] })).violations
  .flatMap(({ id, impact, nodes }) => nodes.map(({ html, failureSummary }) =>
    `axe ${id} (${impact}): ${html.slice(0, 160)} | ${failureSummary.slice(0, 200)}`))"""
LABELS = "label[for], dt, .mantine-Button-root, #llsrbm-transport :is(button, select, .shape)"
DESCRIBED = """(each) => {
  const tip = document.getElementById("llsrbm-tip");
  const other = [...document.querySelectorAll("[role=tooltip]")]
    .some((made) => made.id !== "llsrbm-tip" && made.textContent.trim() && made.offsetHeight > 0);
  return tip.style.display === "block" && tip.textContent.trim() !== "" || other
    || Boolean(each.closest("[title]:not([title=''])"));
}"""


class Mouse:
    """A hand with a mouse, or a finger."""

    def __init__(self, page: Page) -> None:
        self.page = page

    def press(self, found: Locator) -> None:
        found.click()
        self.page.wait_for_timeout(PACE)

    def slide(self, thumb: Locator, *, up: bool = False) -> None:
        """A stretch to the left, or upwards."""
        thumb.scroll_into_view_if_needed()
        box = thumb.bounding_box()
        assert box is not None
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        for pixels in range(2, 22, 2):
            self.page.mouse.move(x - (not up) * pixels, y - up * pixels)
            self.page.wait_for_timeout(PACE)
        self.page.mouse.up()

    def write(self, field: Locator, value: str) -> None:
        field.fill(value)
        self.page.wait_for_timeout(PACE)


class Keys(Mouse):
    """Ten fingers on the keyboard, and nothing else."""

    def press(self, found: Locator) -> None:
        self._reach(found)
        self.page.keyboard.press("Space")
        self.page.wait_for_timeout(PACE)

    def slide(self, thumb: Locator, *, up: bool = False) -> None:
        self._reach(thumb)
        for _ in range(6):
            self.page.keyboard.press("ArrowUp" if up else "ArrowLeft")
            self.page.wait_for_timeout(PACE)

    def write(self, field: Locator, value: str) -> None:
        self._reach(field)
        self.page.keyboard.press("Control+a")
        self.page.keyboard.type(value)
        self.page.keyboard.press("Enter")
        self.page.wait_for_timeout(PACE)

    def _reach(self, found: Locator) -> None:
        found.wait_for(state="attached", timeout=PATIENCE)
        element = found.element_handle()
        for _ in range(FARTHEST):
            if self.page.evaluate("each => each === document.activeElement", element):
                return
            self.page.keyboard.press("Tab")
        raise LookupError(f"the keyboard does not reach {found}")


class Visitor:
    """Attributes: found: what is wrong where, each once."""

    def __init__(self, page: Page, keys: bool, axe: str, out: Path) -> None:
        self.page, self.out, self._axe = page, out, axe
        self.hand = Keys(page) if keys else Mouse(page)
        self.found: dict[str, str] = {}

    def button(self, name: str | re.Pattern[str]) -> Locator:
        return self.page.get_by_role("button", name=name, exact=isinstance(name, str)).first

    def press(self, name: str | re.Pattern[str]) -> None:
        self.hand.press(self.button(name))

    def answered(self) -> None:
        """Wait until the request has its last answer, whatever it is."""
        self.page.wait_for_timeout(5 * PACE)
        self.page.locator('[role="status"][aria-busy="false"]').wait_for()

    def look(self, place: str) -> None:
        """The page is photographed as it stands, and what is wrong is noted."""
        page = self.page
        page.evaluate("llsrbm.player.pause()")
        settled(page)
        with looked_at(page):
            page.screenshot(path=self.out / f"{place}.png")
        if "axe" not in page.evaluate("Object.keys(window)"):
            page.evaluate(self._axe)
        _, covered = page.evaluate(CONTROLS)
        for fault in (*unreadable(page), *covered, *page.evaluate(AXE)):
            self.found.setdefault(fault, place)

    def describe(self) -> Iterator[str]:
        """The labels in sight that say nothing when the pointer rests on them."""
        for label in self.page.locator(LABELS).all():
            if not label.is_visible():
                continue
            self.page.mouse.move(5, 300)
            label.scroll_into_view_if_needed()
            with contextlib.suppress(
                Exception
            ):  # it is disabled, or under something: still looked at
                label.hover(timeout=1000, force=True)
            self.page.wait_for_timeout(500)
            if not label.evaluate(DESCRIBED):
                yield label.evaluate("each => each.ariaLabel || each.textContent.trim()")

    # ---- the walks

    def walk(self, name: str) -> None:
        """All five."""
        for each in self.come_in, self.turn, self.compare, self.open_and_export, self.push:
            began = time.monotonic()
            each(name)
            print(f"  {each.__name__}: {time.monotonic() - began:.0f} s", flush=True)

    def come_in(self, name: str) -> None:
        first = self.page.evaluate(FIRST_PICTURE)
        self.answered()
        controls, _ = self.page.evaluate(CONTROLS)
        self.look(f"{name}-1-first")  # from here on it is drawn only to be photographed
        print(f"{name}: first motion after {first:.2f} s, {len(controls)} controls at first sight")
        print(f"  {', '.join(controls)}", flush=True)
        if len(controls) > MOST_CONTROLS:
            self.found[f"{len(controls)} controls at first sight"] = name
        if first > LATEST:
            self.found[f"first motion after {first:.2f} s"] = name
        self.press("Skip")
        self.press("Play")
        assert self.page.evaluate("llsrbm.player.playing")
        self.press("Pause")
        assert not self.page.evaluate("llsrbm.player.playing")

    def turn(self, name: str) -> None:
        before = float(number(self.page, "Twist [deg]").input_value())
        self.hand.slide(self.page.get_by_role("slider", name="Twist [deg]", exact=True))
        self.answered()
        assert float(number(self.page, "Twist [deg]").input_value()) < before
        self.press("Simulate")
        status(self.page, "Landed", timeout=PATIENCE)
        self.look(f"{name}-2-turned")

    def compare(self, name: str) -> None:
        self.press("Compare models")
        card = self.page.locator("#llsrbm-compare")
        card.get_by_text("Figures").wait_for(timeout=PATIENCE)
        sentence = card.locator("p").inner_text()
        assert len(re.findall(r"\d°", sentence)) >= 3, sentence
        self.look(f"{name}-3-compared")
        self.press("Close the comparison")

    def open_and_export(self, name: str) -> None:
        self.press("Help")
        self.look(f"{name}-4-help")
        self.page.keyboard.press("Escape")
        self.press("Examples")
        self.look(f"{name}-4-gallery")
        card = self.page.locator("#llsrbm-gallery .cards button").filter(has_text=EXAMPLE).first
        self.hand.press(card)
        self.answered()
        self.press("Export…")
        self.look(f"{name}-4-export")
        with self.page.expect_download() as download:
            self.hand.press(self.page.locator("#llsrbm-exports li button").nth(1))
        print(f"  exported {download.value.suggested_filename}", flush=True)

    def push(self, name: str) -> None:
        self.press("Scenario")
        for box in ("Push", "Replan", "Disturb"):
            self.hand.press(self.page.get_by_label(box, exact=True))
        self.hand.write(self.page.get_by_label("Push y [N s]", exact=True), "2")
        self.press("Simulate")
        verdict = self.page.get_by_role("status").filter(has_text=re.compile(r"^\s*(Landed|Fell)"))
        verdict.wait_for(timeout=PATIENCE)
        self.look(f"{name}-5-pushed")
        self.hand.slide(self.page.get_by_role("slider", name=re.compile("^Apex")), up=True)
        self.answered()
        self.look(f"{name}-5-edited")
        self.page.keyboard.press("Control+z")
        self.answered()
        for folder in ("Scenario", "Details"):
            self.press(folder)
        self.look(f"{name}-6-details")


def walk(browser: Browser, url: str, size: tuple[int, int], options: argparse.Namespace) -> int:
    """All five walks at one size, by day and by night; the number of findings."""
    width, height = size
    axe = (options.out / "node_modules/axe-core/axe.min.js").read_text("utf-8")
    count = 0
    for scheme in options.schemes:
        name = f"{width}-{scheme}{'-keys' if options.keys else ''}"
        context = browser.new_context(
            viewport={"width": width, "height": height}, color_scheme=scheme, has_touch=width < 500
        )
        context.add_init_script(f"{ON_DEMAND} window.isLookedAt = true;")
        page = context.new_page()
        page.set_default_timeout(PATIENCE)
        page.goto(url)
        visitor = Visitor(page, options.keys, axe, options.out)
        try:
            visitor.walk(name)
            if options.labels:
                visitor.found |= {f"no description: {label}": name for label in visitor.describe()}
        except (AssertionError, LookupError, Error) as error:
            visitor.found[f"the walk ends: {type(error).__name__} {error}"] = name
        for fault, place in visitor.found.items():
            print(f"  {place}: {fault}", flush=True)
        count += len(visitor.found)
        context.close()
    return count


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--keys", action="store_true", help="by the keyboard alone")
    parser.add_argument("--labels", action="store_true", help="rest on every label, too")
    parser.add_argument("--sizes", nargs="*", type=int, help="widths; all by default")
    parser.add_argument("--schemes", nargs="*", default=("light", "dark"))
    parser.add_argument("--out", type=Path, default=Path("build/walks"))
    parser.add_argument("--url", help="of a server that runs and keeps no token")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    install = ["npm", "install", "--silent", "--prefix", str(options.out), "axe-core"]
    subprocess.run(install, check=True)
    with contextlib.ExitStack() as stack:
        url = options.url
        if url is None:
            server, url = stack.enter_context(serving())
            wait_until_ready(server)
        browser = stack.enter_context(chromium())
        sizes = [size for size in SIZES if size[0] in (options.sizes or [w for w, _ in SIZES])]
        count = sum(walk(browser, url, size, options) for size in sizes)
    print(f"{count} findings")
    sys.exit(count > 0)


if __name__ == "__main__":
    main()
