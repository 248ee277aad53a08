"""A class of thirty on one server's processes: `python -m benchmarks.many_tabs`.

At the pool's level (what a browser adds is in `benchmarks.page` and `benchmarks.tabs`) thirty tabs
are there: ten drag a slider, a new request every 0.3 s from the plan before, as the page does it;
five simulate, each anew as soon as they have their outcome; fifteen look on. Printed is the time
from a slider's request to a plan of it, or of one newer that took its place, against one tab alone
on the same processes; and whether every plan and simulation is of the very request it answers. Exit
status 1 if one is not, or if a tab got none.
"""

import argparse
import math
import sys
import threading
import time
from collections import Counter
from contextlib import closing

import numpy as np

from app.workers.pool import WorkerPool
from app.workers.reports import Failed, Partial, Planned, Simulated
from app.workers.tasks import PlanJump, SimulateJump
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario

TABS, DRAGGING, SIMULATING = 30, 10, 5
STEP_SECONDS = 0.3  # between two requests of a hand on a slider
PATIENCE = 120.0  # s for processes to load their solvers, and for a last answer


class Tab:
    """Submits jobs and keeps how long their answers took."""

    def __init__(self, pool, number):
        self.pool, self.number = pool, number
        self.submitted = {}  # job -> (task, when)
        self.took = {"plan": [], "simulation": []}
        self.answers = self.replaced = self.wrong = 0
        self.failures = []
        self.plan = None
        self.lock = threading.Lock()
        self.answered = threading.Event()

    def submit(self, task):
        with self.lock:  # the answer may come before the number
            self.answered.clear()
            job = self.pool.submit(self.number, task, self.take)
            self.submitted[job] = task, time.monotonic()

    def take(self, report):
        if isinstance(report, Partial):
            return
        with self.lock:
            task, began = self.submitted.pop(report.job)
            now = time.monotonic()
            took = now - began
            if isinstance(report, Planned):
                # Requests that were replaced while they waited get no answer but this.
                older = [job for job in self.submitted if job < report.job]
                self.replaced += len(older)
                self.answers += 1
                self.took["plan"] += [took, *(now - self.submitted.pop(job)[1] for job in older)]
                self.wrong += report.plan.jump != task.jump
                self.plan = report.plan
            elif isinstance(report, Simulated):
                self.took["simulation"].append(took)
                rollout = report.rollout
                self.wrong += rollout.plan.jump != task.plan.jump
                self.wrong += rollout.scenario != task.scenario
            elif isinstance(report, Failed):
                self.failures.append(report.message)
            self.answered.set()

    def drag(self, until):
        step = 0
        while time.monotonic() < until:
            step += 1
            twist = math.radians(60 + 2 * abs(step % 20 - 10) + self.number)
            with self.lock:
                near = self.plan
            self.submit(PlanJump(Jump(twist=twist), near=near, patient=near is None))
            time.sleep(STEP_SECONDS)
        self.answered.wait(PATIENCE)

    def simulate(self, until):
        while time.monotonic() < until:
            self.submit(SimulateJump(self.plan, Scenario(seed=self.number)))
            self.answered.wait(PATIENCE)

    def begin(self):
        """With a plan of its own."""
        self.submit(PlanJump(Jump(twist=math.radians(60 + self.number))))
        assert self.answered.wait(PATIENCE)
        assert self.plan is not None
        self.took["plan"].clear()
        self.answers = 0


def run(tabs, seconds):
    """The first ones drag, the next simulate, the rest look on."""
    until = time.monotonic() + seconds
    works = [tab.drag for tab in tabs[:DRAGGING]]
    works += [tab.simulate for tab in tabs[DRAGGING : DRAGGING + SIMULATING]]
    threads = [threading.Thread(target=work, args=(until,)) for work in works]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def figures(tabs, kind):
    took = np.array([t for tab in tabs for t in tab.took[kind]])
    if not len(took):
        return "none"
    middle, most = np.median(took), np.quantile(took, 0.95)
    return f"{len(took):5d}   median {middle:.3f} s   p95 {most:.3f} s   longest {took.max():.3f} s"


def until_warm(pool, processes):
    end = time.monotonic() + PATIENCE
    while sum(m.idle and bool(m.loaded) for m in pool._members) < processes:
        assert time.monotonic() < end
        time.sleep(0.05)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=40.0, help="of the thirty tabs")
    parser.add_argument("--workers", type=int, default=2, help="processes of the server")
    options = parser.parse_args()
    with closing(WorkerPool(processes=options.workers)) as pool:
        pool.warm_up([PlanJump(Jump())], lambda _: None, lambda: None)
        until_warm(pool, options.workers)
        alone = Tab(pool, 0)
        alone.begin()
        alone.drag(time.monotonic() + options.seconds / 4)
        tabs = [Tab(pool, number) for number in range(TABS)]
        for tab in tabs:
            tab.begin()
        run(tabs, options.seconds)
    print(f"{options.workers} processes")
    print(f"one tab alone drags     {figures([alone], 'plan')}")
    print(f"ten of thirty drag      {figures(tabs, 'plan')}")
    print(f"five of them simulate   {figures(tabs, 'simulation')}")
    wrong = sum(tab.wrong for tab in tabs)
    served = [tab.answers for tab in tabs[:DRAGGING]]
    print(f"plans of each dragging tab  {min(served)} to {max(served)}")
    print(f"requests replaced by newer  {sum(tab.replaced for tab in tabs)}")
    print(f"answers of another's request, or of an older one  {wrong}")
    for failure, times in Counter(f for tab in tabs for f in tab.failures).items():
        print(f"failed {times} x: {failure}")
    return wrong > 0 or not all(served)


if __name__ == "__main__":
    sys.exit(main())
