"""Tabs that connect and close as fast as they go, and what they leave behind.

`python -m benchmarks.connect_loops [--times 1000]`, from the checkout. Half of the tabs close
when they have greeted with a token, as a page that has been there before;
the others at once. The planner is made up.
Prints what the server holds before and after; exits with 1 if sessions or threads are left.
"""

from __future__ import annotations

import argparse
import logging
import os
import sys
import threading
import time
import warnings
from pathlib import Path

from app.designer import Designer
from app.guard.limits import Limits, Rate
from app.workers.pool import WorkerPool
from tests.app.planners import SyntheticPlanner
from tests.app.raw_tab import RawTab

PAGES = 120  # of which every other one's token is used: more than states are kept
FIRST = 50  # loops before memory is looked at: what is loaded once, and the states that are kept
PATIENCE = 60.0  # s for the sessions to end


# One machine opens more tabs here than the door would let in.
_MANY = Rate(1e4, 1e4)
UNLIMITED = Limits(tabs_per_peer=50, handshakes=_MANY, handshakes_per_peer=_MANY)


def resident():
    """Memory of this process, MB."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1024**2


def of_sessions():
    return [each for each in threading.enumerate() if each.name.startswith("session-")]


def held(designer, when):
    print(
        f"{when:24} {len(designer.sessions):3} sessions {len(of_sessions()):3} of their threads "
        f"{threading.active_count():3} threads {designer.tabs.kept:3} kept states "
        f"{resident():6.0f} MB",
        flush=True,
    )


def loops(designer, times):
    for number in range(times):
        if number % 2:
            RawTab(designer.port).close()
        else:
            with RawTab(designer.port, {"tab": f"{number % PAGES:032x}"}) as tab:
                tab.wait(lambda page=tab.page: page.calls("page.connect"), "to be greeted")


def ended(designer):
    """True if all sessions end in time."""
    until = time.monotonic() + PATIENCE
    while (designer.sessions or of_sessions()) and time.monotonic() < until:
        time.sleep(0.01)
    return not designer.sessions and not of_sessions()


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--times", type=int, default=1000)
    times = parser.parse_args().times
    warnings.filterwarnings("ignore", "Queued a ")  # messages to tabs that have gone
    logging.getLogger("websockets").setLevel(logging.CRITICAL)
    designer = Designer(port=0, token="none", pool=WorkerPool(SyntheticPlanner), limits=UNLIMITED)
    with RawTab(designer.port) as tab:
        tab.wait_for_status("Feasible")
    loops(designer, FIRST)
    quiet = ended(designer)
    held(designer, f"after {FIRST} loops")
    began = time.monotonic()
    loops(designer, times)
    took = time.monotonic() - began
    held(designer, f"{times} more, {took:.1f} s")
    quiet = ended(designer) and quiet
    held(designer, f"{time.monotonic() - began - took:.1f} s later")
    with RawTab(designer.port) as tab:
        print(f"the next tab: {tab.wait_for_status('Feasible')}")
    assert designer.tabs.kept <= Limits.tabs
    designer.close()
    return 0 if quiet else 1


if __name__ == "__main__":
    sys.exit(main())
