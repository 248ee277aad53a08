"""Pictures of the page in its states, into `docs/`: `python -m benchmarks.pictures [NAME ...]`.

The README's are among them. Each state is reached as a user would reach it, in headless Chromium.
"""

from __future__ import annotations

import argparse
import io
import subprocess
from collections.abc import Callable
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser, Page

from benchmarks.page import PROGRAM
from tests.app.chromium import PACE, chromium, fill, status

FOLDER = Path(__file__).parents[1] / "docs"
VIEW = {"width": 1500, "height": 1000}
TABLET = {"width": 1024, "height": 768}
PATIENCE = 300_000  # ms; a first start builds solvers
SETTLED = 3000  # ms until everything that was asked for is drawn


def main() -> None:
    """Start a server and take the pictures that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", choices=[[], *STATES])
    names = parser.parse_args().names or list(STATES)
    server = subprocess.Popen(PROGRAM, stdout=subprocess.PIPE, text=True)
    try:
        assert server.stdout is not None
        lines = iter(server.stdout.readline, "")
        address = next(word for line in lines for word in line.split() if word.startswith("http"))
        with chromium() as browser:
            for name in names:
                take(browser, address, name)
    finally:
        server.terminate()
        server.wait()


def take(browser: Browser, address: str, name: str) -> None:
    """Open a tab, bring it into a state, and keep its picture."""
    view = TABLET if name == "tablet" else VIEW
    context = browser.new_context(viewport=view, has_touch=name == "tablet")
    page = context.new_page()
    page.goto(address)
    status(page, "Planned", timeout=PATIENCE)
    close_note(page)
    # As a browser with a graphics processor has it.
    page.evaluate("() => llsrbm.player.send({kind: 'ready', software: false})")
    STATES[name](page)
    page.mouse.move(300, 300)
    page.wait_for_timeout(SETTLED)
    # Few colours are enough, and a fourth of the bytes.
    image = Image.open(io.BytesIO(page.screenshot())).convert("RGB").quantize(256)
    FOLDER.mkdir(exist_ok=True)
    path = FOLDER / f"{name}.png"
    image.save(path, optimize=True)
    print(f"{path.relative_to(FOLDER.parent)}  {path.stat().st_size / 1e3:.0f} kB", flush=True)
    context.close()


# ---- what a user does


def close_note(page: Page) -> None:
    """Viser's remark about software rendering."""
    note = page.locator(".mantine-Notification-closeButton")
    if note.count():
        note.first.click()


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
    status(page, "Planned", timeout=PATIENCE)


def simulate(page: Page, outcome: str = "Landed") -> None:
    """Have the whole robot follow the plan."""
    press(page, "Simulate")
    status(page, outcome, timeout=PATIENCE)


def hold(page: Page, instant: float) -> None:
    """Pause at an instant, s."""
    page.evaluate("t => { llsrbm.player.pause(); llsrbm.player.seek(t); }", instant)


def fold(page: Page, *folders: str) -> None:
    """Close, or open, folders of the panel."""
    for folder in folders:
        page.get_by_text(folder, exact=True).click()
        page.wait_for_timeout(PACE)


def to_the_top(page: Page) -> None:
    """Scroll the panel to its status line."""
    page.evaluate("() => document.querySelector('[role=status]').scrollIntoView()")


# ---- the states


def _designer(page: Page) -> None:
    simulate(page)
    hold(page, 0.62)  # late in flight, feet drawn in
    fold(page, "Design", "Compare")


def _compare(page: Page) -> None:
    choose(page, "Model", "srbm")
    page.wait_for_timeout(300)
    status(page, "Planned", timeout=PATIENCE)
    press(page, "Pin")
    choose(page, "Model", "llsrbm-plus")
    page.wait_for_timeout(300)
    status(page, "Planned", timeout=PATIENCE)
    hold(page, 0.62)
    fold(page, "Jump", "Whole body", "Design")


def _night(page: Page) -> None:
    simulate(page)
    page.get_by_label("Night", exact=True).check()
    hold(page, 0.62)
    to_the_top(page)
    fold(page, "Jump", "Design", "Compare")


def _tablet(page: Page) -> None:
    plan(page, twist=60, forward=0.3)
    hold(page, 0.55)


def _failed(page: Page) -> None:
    fold(page, "Weights and limits")
    page.get_by_label("contact force [N]").fill("160")
    page.wait_for_timeout(PACE)
    to_the_top(page)
    fill(page, "Landing height [m]", 0.3)
    page.get_by_role("button", name="Take ").first.wait_for(timeout=PATIENCE)
    hold(page, 0.55)


def _fell(page: Page) -> None:
    choose(page, "Robot", "slider")
    status(page, "Planned", timeout=PATIENCE)
    choose(page, "Model", "llsrbm")
    page.wait_for_timeout(300)
    status(page, "Planned", timeout=PATIENCE)
    simulate(page, "Fell")
    page.evaluate("() => llsrbm.player.seek(Infinity)")
    page.evaluate("() => llsrbm.player.pause()")


def _weights(page: Page) -> None:
    fold(page, "Jump", "Whole body", "Design", "Compare", "Plots", "Figures", "Show", "File")
    fold(page, "Weights and limits")
    page.get_by_label("foot movement [1/m^2]").fill("0.2")
    page.wait_for_timeout(PACE)
    page.get_by_label("friction [1]").fill("0.4")


def _help(page: Page) -> None:
    fold(page, "Jump", "Whole body", "Design", "Compare", "Plots", "Figures", "Show", "File")
    fold(page, "Help")


def _simulating(page: Page) -> None:
    press(page, "Simulate")
    page.get_by_role("status").filter(has_text="%").wait_for(timeout=PATIENCE)


STATES: dict[str, Callable[[Page], None]] = {
    "designer": _designer,
    "compare": _compare,
    "night": _night,
    "tablet": _tablet,
    "failed": _failed,
    "fell": _fell,
    "weights": _weights,
    "help": _help,
    "simulating": _simulating,
}


if __name__ == "__main__":
    main()
