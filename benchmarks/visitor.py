"""One visitor tries all robots, types and models: `python -m benchmarks.visitor [--minutes 60]`.

A tab over a real connection, without a browser, has the page's menus gone through in order, for
each choice two steps of the twist's slider, and a simulation for each robot. Printed are the most
memory that each computing process held (those that took the place of a heavy one among them), and
the time from a choice to its answer that rests, by tenths of the way. Exit status 1 if a process
held 1.2 GB or more.
"""

import argparse
import sys
import threading
import time
from collections import Counter
from contextlib import closing
from pathlib import Path

import numpy as np

from app.designer import Designer
from app.panel.status import Verdict
from tests.app.raw_tab import PLANNED, RawTab

MOST = 1200.0  # MB
STEPS = 5.0, -5.0  # degrees of twist beside the one that was there
PATIENCE = 600.0  # s for an answer: a solver may have to be built first
TENTHS = 10


class Visitor:
    """Attributes: took: s of each answer, in order; verdicts: how often each came."""

    def __init__(self, tab, session):
        self.tab, self.session = tab, session
        self.took, self.verdicts = [], Counter()

    def set(self, label, value):
        if self.tab.value(label) != value:
            self.took.append(self.answered(lambda: self.tab.set(label, value)))

    def answered(self, act):
        """The time (s) from an act to its answer."""
        before, began = self.session.state, time.monotonic()
        act()
        while self.session.state is before or self._waits():
            if time.monotonic() - began > PATIENCE:
                raise TimeoutError(self.tab.status())
            time.sleep(0.02)
        self.verdicts[self.session.state.status.verdict] += 1
        return time.monotonic() - began

    def _waits(self):
        state = self.session.state
        busy = state.status.busy or state.planning or not state.ready
        return busy and state.status.verdict is not Verdict.FAILED


def visit(visitor, until, robots, types):
    """All that the menus offer, or of them what is chosen, until a time (s, monotonic clock)."""
    tab = visitor.tab

    def options(label, chosen=()):
        return [
            each for each in tab.control(label)["props"]["options"] if each in chosen or not chosen
        ]

    for robot in options("Robot", robots):
        visitor.set("Robot", robot)
        for kind in options("Jump type", types):
            visitor.set("Jump type", kind)
            for model in options("Model"):
                visitor.set("Model", model)
                twist = tab.value("Twist [deg]")
                for step in STEPS:
                    visitor.set("Twist [deg]", twist + step)
                if time.monotonic() > until:
                    return
            print(f"{robot}, {kind}: {visitor.took[-1]:.2f} s", flush=True)
        visitor.answered(lambda: tab.press("Simulate"))


def watch(pool, peaks, stop):
    """Keep the most memory, MB, that each process has held: pid -> MB."""
    while not stop.wait(0.5):
        for pid in [member.process.id for member in pool._members]:
            try:
                lines = Path(f"/proc/{pid}/status").read_text("ascii").splitlines()
            except OSError:  # it has gone, or there is none
                continue
            for line in lines:  # of one that has ended there is none
                if line.startswith("VmHWM"):
                    peaks[pid] = int(line.split()[1]) / 1e3


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--robots", nargs="*", default=(), help="their titles; all by default")
    parser.add_argument("--types", nargs="*", default=(), help="likewise")
    options = parser.parse_args()
    peaks, stop = {}, threading.Event()
    with closing(Designer(port=0, token="none")) as designer:
        threading.Thread(target=watch, args=(designer.pool, peaks, stop), daemon=True).start()
        with RawTab(designer.port) as tab:
            tab.wait_for_status(PLANNED, timeout=PATIENCE)
            visitor = Visitor(tab, designer.sessions[0])
            until = time.monotonic() + 60 * options.minutes
            visit(visitor, until, options.robots, options.types)
        stop.set()
    print(*(f"process {pid}: {most:.0f} MB at most" for pid, most in peaks.items()), sep="\n")
    for tenth, took in enumerate(np.array_split(visitor.took, TENTHS), start=1):
        print(f"answers, tenth {tenth}: median {np.median(took):.2f} s, longest {took.max():.2f} s")
    print(", ".join(f"{count} x {verdict.value}" for verdict, count in visitor.verdicts.items()))
    return max(peaks.values()) >= MOST


if __name__ == "__main__":
    sys.exit(main())
