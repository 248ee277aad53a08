"""A tab as the pool of computing processes knows it: submits jobs and keeps the reports."""

import queue

from app.workers.reports import Partial, Progress
from app.workers.tasks import PlanJump, SimulateJump
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from tests.app.synthetic_plan import synthetic_plan


class Tab:
    def __init__(self, pool, name="tab"):
        self.pool, self.name, self.reports = pool, name, queue.SimpleQueue()

    def submit(self, task):
        return self.pool.submit(self.name, task, self.reports.put)

    def plan(self, twist=0.0, forward=0.0, **how):
        return self.submit(PlanJump(Jump(twist=twist, forward=forward), **how))

    def simulate(self, **scenario):
        return self.submit(SimulateJump(synthetic_plan(Jump(twist=1.0)), Scenario(**scenario)))

    def outcome(self, timeout=60.0):
        while isinstance(report := self.reports.get(timeout=timeout), Partial):
            pass
        return report

    def progress(self, timeout=60.0):
        """The next report of that kind."""
        while not isinstance(report := self.reports.get(timeout=timeout), Progress):
            assert isinstance(report, Partial)
        return report

    def wait_until_running(self, job):
        while (report := self.reports.get(timeout=60)).text.startswith("waiting: "):
            pass
        assert isinstance(report, Progress)
        assert report.job == job
