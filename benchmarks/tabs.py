"""Twenty tabs on one server, and a hundred after each other: `python -m benchmarks.tabs`.

Ten of twenty tabs change a slider for ten seconds, each as fast as its plans come; then all ten
drag at once, a value every 50 ms, and every tab's plan is exported and compared with its own last
value.
After that a hundred tabs are opened and closed; memory of the server and its processes is printed
after every tenth.
"""

import io
import json
import math
import re
import sys
import threading
import time
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np

from benchmarks.served import resident, serving, wait_until_ready
from tests.app.raw_tab import PLANNED, RawTab

TABS, DRAGGING, DRAG_SECONDS = 20, 10, 10.0
BURST, STEP_SECONDS = 30, 0.05  # values of the drag at the end, and the time between two
PATIENCE = 20.0  # s for the last plan to come
OPENED, REPORT_EVERY = 100, 10


class Tab(RawTab):
    """Keeps its slider's value and the times its plans took."""

    def __init__(self, port, number):
        super().__init__(port)
        self.number = number
        self.twist = None
        self.latencies = []
        self.wait_for_status(PLANNED, timeout=60)

    def request(self, twist):
        self.twist = twist
        self.set("Twist [deg]", twist)

    @property
    def motions(self):
        """How many the page was sent so far."""
        return sum(".player.load(" in script for script in list(self.scripts))

    def plan_and_wait(self, twist):
        shown, began = self.motions, time.monotonic()
        self.request(twist)
        self.wait(lambda: self.motions > shown, "a motion", 60)
        self.latencies.append(time.monotonic() - began)

    def drag(self, until):
        step = 0
        while time.monotonic() < until:
            step += 1
            self.plan_and_wait(30 + 2 * abs(step % 60 - 30) - 3 * self.number)

    def burst(self):
        for step in range(BURST):
            self.request(-step + 5 * self.number)
            time.sleep(STEP_SECONDS)

    def exported_twist(self):
        count = len(self.downloads)
        self.set("Format", "npz")
        time.sleep(0.1)
        self.press("Export")
        self.wait(lambda: len(self.downloads) > count, "a download")
        plan = np.load(io.BytesIO(self.downloads[-1][1]), allow_pickle=False)
        return math.degrees(json.loads(str(plan["meta"]))["request"]["twist"])

    def comes_to(self, twist):
        end = time.monotonic() + PATIENCE
        while abs(self.exported_twist() - twist) > 1e-6:
            if time.monotonic() > end:
                return False
        return True


def in_threads(work, tabs):
    threads = [threading.Thread(target=work, args=(tab,)) for tab in tabs]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def share(port):
    tabs = [Tab(port, number) for number in range(TABS)]
    default = tabs[-1].exported_twist()
    dragging, watching = tabs[:DRAGGING], tabs[DRAGGING:]
    until = time.monotonic() + DRAG_SECONDS
    in_threads(lambda tab: tab.drag(until), dragging)
    print(f"{DRAGGING} of {TABS} tabs change a slider for {DRAG_SECONDS:g} s:")
    for tab in dragging:
        middle, late = np.percentile(tab.latencies, [50, 95])
        print(
            f"  tab {tab.number}: {len(tab.latencies):4d} plans, {1e3 * middle:5.0f} ms median, "
            f"{1e3 * late:5.0f} ms p95, {1e3 * max(tab.latencies):5.0f} ms worst"
        )
    counts = [len(tab.latencies) for tab in dragging]
    print(f"  fewest / most plans             {min(counts) / max(counts):6.2f}")

    in_threads(Tab.burst, dragging)
    began = time.monotonic()
    wrong = [tab for tab in dragging if not tab.comes_to(tab.twist)]
    print(f"  after a drag of all, the last has its plan in {time.monotonic() - began:6.2f} s")
    wrong += [tab for tab in watching if not tab.comes_to(default)]
    print(f"tabs without the plan of their own last value: {len(wrong)} of {TABS}")
    for tab in tabs:
        tab.close()
    return not wrong


def open_and_close(port, pid):
    print("tabs opened and closed    server MB    its processes MB    threads")
    for opened in range(OPENED + 1):
        if opened % REPORT_EVERY == 0:
            time.sleep(1.0)
            server, processes = resident(pid)
            status = Path(f"/proc/{pid}/status").read_text()
            threads = re.search(r"Threads:\s+(\d+)", status).group(1)
            print(f"{opened:8d} {server:27.0f} {processes:16.0f} {threads:>14s}", flush=True)
        with RawTab(port) as tab:
            tab.wait_for_status(PLANNED, timeout=60)


def main():
    with serving("--token", "none") as (server, url):
        port = urlsplit(url).port
        wait_until_ready(server)
        fine = share(port)
        open_and_close(port, server.pid)
    return 0 if fine else 1


if __name__ == "__main__":
    sys.exit(main())
