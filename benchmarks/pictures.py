"""Pictures of the page in its states, into `docs/`: `python -m benchmarks.pictures [NAME ...]`.

The README's are among them. Each state is reached as a user would reach it, in headless Chromium.
"""

import argparse
import io
import json
from collections.abc import Callable
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser, Page

from benchmarks.served import serving, wait_until_ready
from tests.app.chromium import PACE, VIEW, chromium, fill, status, tab, tick, unfold
from tests.app.labels import labels

FOLDER = Path(__file__).parents[1] / "docs"
LAPTOP = {"width": 1280, "height": 800}
DESKTOP = {"width": 1920, "height": 1080}
TABLET = {"width": 820, "height": 1180}  # held upright
PATIENCE = 300_000  # ms; a first start builds solvers
# The page takes itself for one with a graphics processor: all triangles, shadows, smooth edges.
WITH_GRAPHICS = """addEventListener('DOMContentLoaded', () =>
  Object.defineProperty(llsrbm, 'software', { get: () => false, set() {} }));"""
QUALITY = 90  # of WebP: full colour in a fourth of the bytes of PNG
RECORD = FOLDER / "pictures.json"  # labels of the page that the pictures show
SETTLED = 3000  # ms until everything that was asked for is drawn


def main() -> None:
    """Start a server and take the pictures that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", choices=[[], *STATES])
    names = parser.parse_args().names or list(STATES)
    with serving() as (server, address), chromium() as browser:
        wait_until_ready(server)
        for name in names:
            take(browser, address, name)
        if names == list(STATES):
            record(browser, address)


def take(browser: Browser, address: str, name: str) -> None:
    """Open a tab, bring it into a state, and keep its picture."""
    view, reach = STATES[name]
    context = browser.new_context(viewport=view, has_touch=view is TABLET)
    # As a browser with a graphics processor has it.
    context.add_init_script(WITH_GRAPHICS)
    context.add_init_script("localStorage.setItem('llsrbm.tour', 'seen')")
    page = context.new_page()
    page.goto(address)
    status(page, "Feasible", timeout=PATIENCE)
    close_note(page)
    reach(page)
    page.mouse.move(300, 300)
    page.wait_for_timeout(SETTLED)
    path = FOLDER / f"{name}.webp"
    Image.open(io.BytesIO(page.screenshot())).convert("RGB").save(path, quality=QUALITY, method=6)
    print(f"{path.relative_to(FOLDER.parent)}  {path.stat().st_size / 1e3:.0f} kB", flush=True)
    context.close()


def record(browser: Browser, address: str) -> None:
    """Keep the labels that the pictures were taken with (`tests/app/test_pictures.py`)."""
    context = browser.new_context(viewport=VIEW)
    context.add_init_script("localStorage.setItem('llsrbm.tour', 'seen')")
    page = context.new_page()
    page.goto(address)
    status(page, "Feasible", timeout=PATIENCE)
    close_note(page)
    facts = {"labels": labels(page), "pictures": sorted(STATES)}
    RECORD.write_text(json.dumps(facts, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    context.close()


# ---- what a user does


def close_note(page: Page) -> None:
    """Viser's remark about software rendering."""
    page.evaluate(
        "document.querySelectorAll('.mantine-Notification-closeButton').forEach(b => b.click())"
    )


def press(page: Page, button: str) -> None:
    """Click a button of the panel."""
    page.get_by_role("button", name=button, exact=True).click()
    page.wait_for_timeout(PACE)


def choose(page: Page, label: str, option: str) -> None:
    """Choose from one of the panel's lists."""
    page.get_by_label(label).click()
    page.get_by_role("option", name=option, exact=True).click()
    page.wait_for_timeout(PACE)


def plan(page: Page, **values: float) -> None:
    """Enter a task and wait for its plan."""
    labels = {
        "twist": "Twist [deg]",
        "forward": "Forward [m]",
        "lateral": "Lateral [m]",
        "height": "Landing height [m]",
    }
    for name, value in values.items():
        fill(page, labels[name], value)
    page.wait_for_timeout(300)
    status(page, "Feasible", timeout=PATIENCE)


def simulate(page: Page, outcome: str = "Landed") -> None:
    """Have the whole robot follow the plan."""
    press(page, "Simulate")
    status(page, outcome, timeout=PATIENCE)


def hold(page: Page, instant: float) -> None:
    """Pause at an instant, s."""
    page.evaluate("t => { llsrbm.player.pause(); llsrbm.player.seek(t); }", instant)


def check(page: Page, *labels: str) -> None:
    """Tick boxes of the scenario."""
    for label in labels:
        page.get_by_label(label, exact=True).check()
        page.wait_for_timeout(PACE)


def bring_into_sight(page: Page, part: str) -> None:
    """Scroll a tab or a folder as little as shows a part of it."""
    page.locator(part).first.evaluate("part => part.scrollIntoView({ block: 'nearest' })")


def without_plots(page: Page) -> None:
    """Close the area of the plots."""
    tab(page, "Plots")
    page.get_by_label("Plot area", exact=True).uncheck()
    page.wait_for_timeout(PACE)
    fold_details(page)


def fold_details(page: Page) -> None:
    """Fold what a first jump does not need."""
    page.get_by_role("button", name="Details", exact=True).click()
    page.wait_for_timeout(PACE)


# ---- the states


def _designer(page: Page) -> None:
    simulate(page)
    hold(page, 0.62)  # late in flight, feet drawn in


def _large(page: Page) -> None:
    simulate(page)
    tab(page, "Results")
    hold(page, 0.62)


def _compare(page: Page) -> None:
    press(page, "Compare models")
    page.locator("#llsrbm-compare").get_by_text("Figures").wait_for(timeout=PATIENCE)
    hold(page, 0.62)


def _night(page: Page) -> None:
    without_plots(page)
    simulate(page)
    tick(page, "Dark mode")
    hold(page, 0.62)


def _overlays(page: Page) -> None:
    without_plots(page)
    plan(page, twist=60, forward=0.3)
    for name in ("Friction pyramids", "Support polygon", "Centre of pressure", "Angular momentum"):
        tick(page, name)
    hold(page, 0.3)


def _tablet(page: Page) -> None:
    plan(page, twist=60, forward=0.3)
    hold(page, 0.55)


def _failed(page: Page) -> None:
    for label, value in (("Twist [deg]", 180), ("Forward [m]", 0.6), ("Landing height [m]", 0.3)):
        fill(page, label, value)
    page.get_by_role("button", name="Use nearest").wait_for(timeout=PATIENCE)
    page.locator("[role=status][aria-busy=false]").wait_for(timeout=PATIENCE)  # the whole body's
    hold(page, 0.55)


def _push(page: Page) -> None:
    without_plots(page)
    plan(page, twist=60)
    unfold(page, "Scenario")
    hold(page, 0.5)
    check(page, "Replan", "Push")
    fill(page, "Push y [N s]", 14)
    page.wait_for_timeout(300)
    simulate(page)
    hold(page, 0.6)


def _seeds(page: Page) -> None:
    unfold(page, "Scenario")
    press(page, "Simulate 20 seeds")
    page.get_by_role("status").filter(has_text=" seeds.").wait_for(timeout=PATIENCE)
    bring_into_sight(page, ".llsrbm-seeds")


def _atlas(page: Page) -> None:
    plan(page, twist=120, forward=0.3)
    unfold(page, "Atlas")
    choose(page, "Colour", "Limiting constraint")
    page.locator(".llsrbm-atlas .legend").wait_for(timeout=PATIENCE)
    bring_into_sight(page, ".llsrbm-atlas svg, .llsrbm-atlas canvas")
    hold(page, 0.55)


STATES: dict[str, tuple[dict[str, int], Callable[[Page], None]]] = {
    "designer": (LAPTOP, _designer),
    "large": (DESKTOP, _large),
    "compare": (DESKTOP, _compare),
    "night": (LAPTOP, _night),
    "overlays": (LAPTOP, _overlays),
    "tablet": (TABLET, _tablet),
    "failed": (LAPTOP, _failed),
    "push": (LAPTOP, _push),
    "seeds": (LAPTOP, _seeds),
    "atlas": (LAPTOP, _atlas),
}


if __name__ == "__main__":
    main()
