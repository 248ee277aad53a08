"""Computing processes are killed in mid-work again and again: `python -m benchmarks.pool_deaths`.

Twenty tabs plan and simulate all the time, each its next job as soon as it has the outcome of the
last; a process that works on a job of theirs is killed, and as soon as one works again the next.
Counted are jobs without an outcome, with two, or with a report after it; and how long a tab waits
until it is delays of the death. Exit status 1 if a job is lost or a tab is stuck.
"""

from __future__ import annotations

import argparse
import math
import os
import random
import signal
import sys
import threading
import time
from collections import Counter

import numpy as np

from app.workers.pool import WorkerPool
from app.workers.reports import Failed, Partial, Planned
from app.workers.tasks import PlanJump, SimulateJump
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from tests.app.planners import ITERATING, SyntheticPlanner
from tests.app.synthetic_plan import synthetic_plan

TABS = 20
PATIENCE = 120.0  # s for an outcome: twenty jobs of up to a second on two processes
DIED = "The computing process ended unexpectedly (signal 9) and was restarted."


class Tab:
    """Has one job at a time; keeps what it gets."""

    def __init__(self, pool, number, simulated):
        self.pool, self.number, self.simulated = pool, number, simulated
        self.random = random.Random(number)
        self.outcomes, self.late, self.submitted = {}, 0, {}
        self.heard_of_death = []
        self.answered = threading.Event()
        self.going_on = True
        self.thread = threading.Thread(target=self.work)

    def work(self):
        while self.going_on:
            if not self.submit(self.task()):
                return

    def task(self):
        if self.random.random() < 0.3:
            return SimulateJump(self.simulated, Scenario(seed=1))
        jump = Jump(twist=ITERATING, forward=self.number / 100)  # takes a second
        return PlanJump(jump if self.random.random() < 0.5 else Jump(forward=self.number / 100))

    def submit(self, task):
        self.answered.clear()
        began = time.monotonic()
        job = self.pool.submit(self.number, task, self.take)
        self.submitted[job] = task, began
        return self.answered.wait(PATIENCE)

    def take(self, report):
        if report.job in self.outcomes:
            self.late += 1
        elif not isinstance(report, Partial):
            self.outcomes[report.job] = report
            if isinstance(report, Failed) and report.message == DIED:
                self.heard_of_death.append(time.monotonic())
            self.answered.set()

    @property
    def lost(self):
        return [job for job in self.submitted if job not in self.outcomes]

    @property
    def wrong(self):
        """Plans of another tab's request."""
        plans = [report.plan for report in self.outcomes.values() if isinstance(report, Planned)]
        return sum(not math.isclose(plan.jump.forward, self.number / 100) for plan in plans)


def kill_one(pool, chance):
    """Kill a process in mid-work; the time, and the tab whose job it was."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        for member in chance.sample(pool._members, len(pool._members)):
            entry, process = member.working_on, member.process.id
            if entry is None or process is None or not member.ready:
                continue
            time.sleep(chance.uniform(0.0, 0.1))
            if member.working_on is entry and member.process.id == process:
                os.kill(process, signal.SIGKILL)
                return time.monotonic(), entry.tab, entry.job.number
        time.sleep(0.005)
    raise SystemExit("no process works any more: stuck")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--times", type=int, default=100, help="how often a process is killed")
    parser.add_argument("--tabs", type=int, default=TABS)
    options = parser.parse_args()
    chance = random.Random(0)
    pool = WorkerPool(SyntheticPlanner, processes=2)
    simulated = synthetic_plan(Jump(twist=1.0))
    tabs = [Tab(pool, number, simulated) for number in range(options.tabs)]
    threads_before = threading.active_count()
    for tab in tabs:
        tab.thread.start()
    kills = []
    began = time.monotonic()
    for count in range(options.times):
        kills.append(kill_one(pool, chance))
        killed = count + 1
        # The next one only when this one's tab knows, so that every death has its report.
        _, tab, job = kills[-1]
        end = time.monotonic() + PATIENCE
        while job not in tabs[tab].outcomes and time.monotonic() < end:
            time.sleep(0.005)
        if killed % 10 == 0:
            print(f"{killed:4d} killed after {time.monotonic() - began:5.0f} s", flush=True)
    for tab in tabs:
        tab.going_on = False
    for tab in tabs:
        tab.thread.join()
    last = [tab.submit(PlanJump(Jump(forward=tab.number / 100))) for tab in tabs]

    delays, missed = [], 0
    for at, tab, job in kills:
        outcome = tabs[tab].outcomes.get(job)
        if isinstance(outcome, Failed):
            delays.append(next(t for t in tabs[tab].heard_of_death if t >= at) - at)
        else:  # it had its result in the same moment
            missed += 1
    outcomes = Counter(type(r).__name__ for tab in tabs for r in tab.outcomes.values())
    submitted = sum(len(tab.submitted) for tab in tabs)
    lost = sum(len(tab.lost) for tab in tabs)
    late, wrong = sum(tab.late for tab in tabs), sum(tab.wrong for tab in tabs)
    failed = outcomes["Failed"]
    counts = ", ".join(f"{count} {name}" for name, count in sorted(outcomes.items()))
    print(f"{options.tabs} tabs, {options.times} processes killed in mid-work")
    print(f"jobs                                   {submitted} ({counts})")
    # A process may die right after it has sent a result; its next job fails then, or none.
    print(f"jobs that failed by a death            {failed}; {missed} had their result already")
    print(f"lost                                   {lost}")
    print(f"reports after an outcome               {late}")
    print(f"plans of another tab's request         {wrong}")
    print(f"tabs that still get their plan         {sum(last)} of {len(tabs)}")
    if delays:
        middle, late_ones, most = 1e3 * np.percentile(delays, [50, 95, 100])
        print(
            f"from the kill to the report            {middle:.0f} ms median, "
            f"{late_ones:.0f} ms p95, {most:.0f} ms worst"
        )
    print(f"threads before and after               {threads_before} {threading.active_count()}")
    began = time.monotonic()
    pool.close()
    print(f"closed in                              {time.monotonic() - began:.2f} s")
    fine = not lost and not late and not wrong and all(last) and failed <= options.times
    return 0 if fine else 1


if __name__ == "__main__":
    sys.exit(main())
