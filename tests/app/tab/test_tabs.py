"""Ten tabs at once, spoken to as browsers would: each gets its own result, none another's."""

from __future__ import annotations

import io
import json
import math
import threading
import time

import numpy as np
import pytest

from tests.app.raw_tab import RawTab

TABS, DRAGGING = 10, 5


@pytest.fixture
def tabs(designer):
    opened = [RawTab(designer.port) for _ in range(TABS)]
    for tab in opened:
        tab.wait_for_status("Planned", timeout=60)
    yield opened
    for tab in opened:
        tab.close()


def exported_twist(tab):
    """Of the plan that the tab shows, in degrees."""
    tab.set("Format", "npz")
    time.sleep(0.1)  # which format is read when the button is pressed, not before
    before = len(tab.downloads)
    tab.press("Export")
    tab.wait(lambda: len(tab.downloads) > before, "a download")
    meta = json.loads(str(np.load(io.BytesIO(tab.downloads[-1][1]))["meta"]))
    return math.degrees(meta["request"]["twist"])


def test_five_of_ten_tabs_drag_at_once(tabs):
    def drag(number):
        for step in range(30):
            tabs[number].set("Twist [deg]", 10 * number - step)
            time.sleep(0.05)

    threads = [threading.Thread(target=drag, args=(i,)) for i in range(DRAGGING)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for number, tab in enumerate(tabs):
        expected = 10 * number - 29 if number < DRAGGING else 90
        deadline = time.monotonic() + 20
        while exported_twist(tab) != pytest.approx(expected, abs=1e-3):
            assert time.monotonic() < deadline
            time.sleep(0.1)
