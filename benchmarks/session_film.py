"""One minute with the page as a film for the README: `python -m benchmarks.session_film`.

A slider is dragged, the jump simulated, a model compared and the motion exported, in headless
Chromium; what it draws is recorded as it comes, into `docs/session.webp`.
"""

from __future__ import annotations

import base64
import io
import subprocess
import time
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import Page

from benchmarks.page import PROGRAM
from benchmarks.pictures import WITH_GRAPHICS, choose, close_note, press, simulate, tab
from tests.app.chromium import chromium, status

FILE = Path(__file__).parents[1] / "docs" / "session.webp"
VIEW = {"width": 1280, "height": 800}
SIZE = (960, 600)  # pixels of the film
RATE = 6.0  # frames/s of the film
QUALITY = 55
STEP = 0.1  # s between steps of a hand


class Recorder:
    """Takes what the browser draws, with the time at which it came."""

    def __init__(self, page: Page):
        self.frames: list[tuple[float, bytes]] = []
        self._page = page
        self._devtools = page.context.new_cdp_session(page)
        self._devtools.on("Page.screencastFrame", self._take)
        self._devtools.send("Page.startScreencast", {"format": "jpeg", "quality": 85})

    def _take(self, frame):
        self.frames.append((time.monotonic(), base64.b64decode(frame["data"])))
        self._devtools.send("Page.screencastFrameAck", {"sessionId": frame["sessionId"]})

    def stop(self):
        self._devtools.send("Page.stopScreencast")


def drag(page: Page, label: str, there: float, seconds: float) -> None:
    """Draw a slider to a share of its width with the mouse."""
    row = page.get_by_text(label, exact=True).locator(
        "xpath=ancestor::div[.//*[@role='slider']][1]"
    )
    thumb = row.get_by_role("slider").first
    box, track = thumb.bounding_box(), row.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    end = x + there * track["width"]
    page.mouse.move(x, y, steps=5)
    page.mouse.down()
    for share in np.linspace(0, 1, round(seconds / STEP)):
        page.mouse.move(x + (end - x) * share, y)
        page.wait_for_timeout(1000 * STEP)
    page.mouse.up()


def story(page: Page) -> None:
    """The first minute of a visitor."""
    page.wait_for_timeout(2500)
    drag(page, "Twist [deg]", -0.08, 5.0)
    status(page, "Planned", timeout=60_000)
    page.wait_for_timeout(2500)
    drag(page, "Forward [m]", 0.06, 3.0)
    status(page, "Planned", timeout=60_000)
    page.wait_for_timeout(3000)
    simulate(page)
    page.wait_for_timeout(6000)
    tab(page, "Figures")
    page.wait_for_timeout(1000)
    press(page, "Pin")
    choose(page, "Model", "SRBM")
    page.wait_for_timeout(500)
    status(page, "Planned", timeout=60_000)
    page.wait_for_timeout(6000)
    choose(page, "Format", "mcap")
    page.wait_for_timeout(1000)
    with page.expect_download():
        page.get_by_role("button", name="Export", exact=True).click()
    page.wait_for_timeout(2500)
    page.get_by_label("Night", exact=True).check() if page.get_by_label(
        "Night", exact=True
    ).is_visible() else None
    page.wait_for_timeout(3000)


def main() -> None:
    """Start a server, record, write."""
    server = subprocess.Popen(PROGRAM, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        lines = iter(server.stdout.readline, "")
        address = next(word for line in lines for word in line.split() if word.startswith("http"))
        while server.stderr.readline() != "ready\n":
            pass
        with chromium() as browser:
            context = browser.new_context(viewport=VIEW, accept_downloads=True)
            context.add_init_script(WITH_GRAPHICS)
            context.add_init_script("localStorage.setItem('llsrbm.tour', 'seen')")
            page = context.new_page()
            page.goto(address)
            status(page, "Planned", timeout=300_000)
            close_note(page)
            recorder = Recorder(page)
            story(page)
            recorder.stop()
            context.close()
    finally:
        server.terminate()
        server.communicate()
    write(recorder.frames)


def write(frames: list[tuple[float, bytes]]) -> None:
    """Frames at a steady rate, each the newest one at its time."""
    times = np.array([at for at, _ in frames])
    ticks = np.arange(times[0], times[-1], 1 / RATE)
    chosen = np.searchsorted(times, ticks, side="right") - 1
    pictures = [
        Image.open(io.BytesIO(frames[i][1])).convert("RGB").resize(SIZE, Image.Resampling.LANCZOS)
        for i in chosen
    ]
    pictures[0].save(
        FILE,
        save_all=True,
        append_images=pictures[1:],
        duration=round(1000 / RATE),
        loop=0,
        quality=QUALITY,
        method=4,
    )
    seconds, size = len(pictures) / RATE, FILE.stat().st_size / 1e6
    print(f"{FILE.name}: {seconds:.0f} s, {len(pictures)} frames, {size:.1f} MB")


if __name__ == "__main__":
    main()
