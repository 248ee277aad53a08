"""The README's picture, from the page itself: `python -m benchmarks.picture`, from the checkout."""

from __future__ import annotations

import subprocess
from pathlib import Path

from benchmarks.page import PROGRAM
from tests.app.chromium import chromium, fill, status

PICTURE = Path(__file__).parents[1] / "docs" / "designer.png"
VIEW = {"width": 1400, "height": 860}
INSTANT = 0.48  # s into the 90 degree twist: late in flight, feet drawn in


def main() -> None:
    """Start a server, open a tab, hold the motion in flight and take the picture."""
    server = subprocess.Popen(PROGRAM, stdout=subprocess.PIPE, text=True)
    try:
        assert server.stdout is not None
        lines = iter(server.stdout.readline, "")
        address = next(word for line in lines for word in line.split() if word.startswith("http"))
        with chromium() as browser:
            page = browser.new_page(viewport=VIEW)
            page.goto(address)
            status(page, "Planned", timeout=90_000)
            fill(page, "Time [s]", INSTANT)
            # viser's note on software rendering is about this machine, not about the page.
            page.locator(".mantine-Notification-closeButton").first.click()
            page.wait_for_timeout(1500)
            PICTURE.parent.mkdir(exist_ok=True)
            page.screenshot(path=PICTURE)
    finally:
        server.terminate()
        server.wait()
    print(f"{PICTURE} written")


if __name__ == "__main__":
    main()
