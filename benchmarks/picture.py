"""The README's pictures, from the page itself: `python -m benchmarks.picture` in the checkout."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path

from playwright.sync_api import Page

from benchmarks.page import PROGRAM
from tests.app.chromium import PACE, chromium, fill, status

FOLDER = Path(__file__).parents[1] / "docs"
VIEW = {"width": 1500, "height": 1000}
FOLDED = ("Jump", "Whole body")  # so that timeline and plots are in view
PATIENCE = 300_000  # ms; a first start builds solvers


@dataclass(frozen=True)
class Picture:
    """A robot's example, simulated, held at an instant, s."""

    file: str
    robot: str
    instant: float


PICTURES = (
    Picture("designer.png", "anymal", 0.62),  # late in flight, feet drawn in
    Picture("slider.png", "slider", 0.62),  # above the box, about to land
)


def main() -> None:
    """Start a server, open a tab a picture."""
    server = subprocess.Popen(PROGRAM, stdout=subprocess.PIPE, text=True)
    try:
        assert server.stdout is not None
        lines = iter(server.stdout.readline, "")
        address = next(word for line in lines for word in line.split() if word.startswith("http"))
        with chromium() as browser:
            for picture in PICTURES:
                page = browser.new_page(viewport=VIEW)
                page.goto(address)
                take(page, picture)
                page.close()
    finally:
        server.terminate()
        server.wait()


def take(page: Page, picture: Picture) -> None:
    """Choose the robot, simulate its example, and take the picture."""
    status(page, "Planned", timeout=PATIENCE)
    # viser's note on software rendering is about this machine, not about the page.
    page.locator(".mantine-Notification-closeButton").first.click()
    if page.get_by_label("Robot").input_value() != picture.robot:
        page.get_by_label("Robot").click()
        page.get_by_role("option", name=picture.robot, exact=True).click()
        status(page, "Planning")
        status(page, "Planned", timeout=PATIENCE)
    page.wait_for_timeout(PACE)
    page.get_by_role("button", name="Simulate").click()
    status(page, "Landed", timeout=PATIENCE)
    fill(page, "Time [s]", picture.instant)
    for folder in FOLDED:
        page.get_by_text(folder, exact=True).click()
    page.get_by_role("status").scroll_into_view_if_needed()
    page.mouse.move(300, 900)
    page.wait_for_timeout(3000)
    path = FOLDER / picture.file
    path.parent.mkdir(exist_ok=True)
    page.screenshot(path=path)
    print(f"{path} written")


if __name__ == "__main__":
    main()
