"""One tab's work in the pool: what it has asked for, and what came of it.

Reports of the newest job are outcomes; of older ones only a plan is worth showing, while a slider
moves.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable

from app.compute.pool import WorkerPool
from app.compute.protocol import (
    Cancelled,
    Failed,
    FindNearest,
    Found,
    Nearest,
    PlanJump,
    Planned,
    Prepare,
    Prepared,
    Progress,
    Report,
    SeedDone,
    Simulated,
    SimulatedSoFar,
    SimulateJump,
    Task,
)
from app.motion.planned_motion import presentable
from app.panel import summaries
from app.panel.panel import Panel
from app.session.drag_planning import DragPlanning
from app.session.stage import Stage
from llsrbm.jump import Jump
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.scenario import Scenario
from llsrbm.tuning import Tuning


class Desk:
    """Asks and shows; for one thread.

    Attributes:
        nearest: a jump that can be planned, on offer in place of one that cannot; or None.
    """

    def __init__(
        self,
        tab: Hashable,
        pool: WorkerPool,
        panel: Panel,
        stage: Stage,
        *,
        listener: Callable[[Report], None],
        prepared: Callable[[str], None],
        planned: Callable[[], None],
    ) -> None:
        """Nothing is asked for.

        Args:
            tab: the pool's name for this tab.
            pool: computes.
            panel: tells how it goes.
            stage: shows what comes of it.
            listener: is called from the pool's thread with what `hear` shall hear.
            prepared: called with a robot's name when it can be drawn.
            planned: called when the plan of the newest request is shown, as it will stay.
        """
        self._tab = tab
        self._pool = pool
        self._panel = panel
        self._stage = stage
        self._listener = listener
        self._prepared = prepared
        self._planned = planned
        self._live = DragPlanning()
        self._awaited: Task | None = None  # the newest job's, until its outcome is there
        self._job = 0  # the newest one
        self._shown_job = 0
        self._dropped = 0  # this job and those before it are of no interest any more
        self._failure = ""  # why the newest request cannot be planned
        self.nearest: Nearest | None = None

    # ---- asking

    def prepare(self, robot: str) -> None:
        """Have what drawing a robot needs computed, unless that is under way."""
        if self._awaited != Prepare(robot):
            self._live.forget()
            self._submit(Prepare(robot))
            self._panel.show_status("Planning", "begins when the robot is ready.", busy=True)

    def plan(self, jump: Jump, tuning: Tuning) -> None:
        """Plan a jump of the robot that is shown, unless that is what was asked for last."""
        task = self._live.ask(jump, tuning, self._stage.plan)
        if task is not None:
            self.withdraw_nearest()
            self._submit_plan(task)

    def show(self, plan: Plan, rollout: Rollout | None = None, of: str = "") -> None:
        """Show a plan that is there already, as if it had been asked for; with its simulation.

        Args:
            plan: to show; the next one may start from it.
            rollout: what followed it.
            of: where both are from, in words, if that is to be said.
        """
        self._drop()
        self._live.forget()
        self._live.ask(plan.jump, plan.tuning, None)
        self.withdraw_nearest()
        self._stage.show_plan(plan)
        said = f"{of}: " if of else ""
        if rollout is not None:
            self._stage.show_rollout(rollout)
            word, rest = summaries.simulated_line(rollout)
            self._panel.show_status(word, said + rest)
        elif plan.solved:
            self._panel.show_status("Planned", said + summaries.planned_line(plan))
        else:
            self._panel.show_status(
                "Failed",
                f"{said}the planner did not converge, largest violation "
                f"{summaries.worst(plan.violations)}.",
            )

    def _drop(self) -> None:
        """Nothing that was asked for before shall be shown any more."""
        if self._awaited is not None:
            self._awaited = None
            self._pool.cancel(self._tab)
        self._dropped = self._job

    def simulate(self, plan: Plan, scenario: Scenario) -> None:
        """Have the whole robot follow the plan that is shown."""
        self._submit(SimulateJump(plan, scenario))
        self._panel.show_status("Simulating", "...", busy=True)

    def cancel(self) -> None:
        """Stop what is going on."""
        self._pool.cancel(self._tab)

    def withdraw_nearest(self) -> None:
        """No offer any more."""
        self.nearest = None
        self._panel.offer_nearest(None)

    @property
    def planning(self) -> bool:
        """Whether the plan that is shown is going to be replaced."""
        return isinstance(self._awaited, PlanJump) or not self._live.settled

    @property
    def wait(self) -> float | None:
        """Seconds until `step` is due, or None."""
        return self._live.wait

    def step(self) -> None:
        """Do what is due: a request that has rested is planned from scratch."""
        rested = self._live.due()
        if rested is not None:
            self._submit_plan(rested)

    def _submit_plan(self, task: PlanJump) -> None:
        following = not task.patient and isinstance(self._awaited, PlanJump)
        self._submit(task)
        if not following:
            self._panel.show_status("Planning", "...", busy=True)

    def _submit(self, task: Task) -> None:
        self._awaited = task
        self._job = self._pool.submit(self._tab, task, self._listener)

    # ---- hearing

    def hear(self, report: Report) -> None:
        """Show what the pool reports."""
        if report.job <= self._dropped or isinstance(report, SimulatedSoFar | SeedDone):
            return
        newest = report.job == self._job
        if isinstance(report, Planned) and not newest:
            self._show_plan(report, moving=True)
            return
        if not newest:
            return
        task = self._awaited
        if not isinstance(report, Progress):
            self._awaited = None
            if isinstance(task, PlanJump):
                self._live.answered(task)
        match report:
            case Progress():
                self._tell_progress(report)
            case Prepared(robot=robot):
                self._prepared(robot)
            case Planned():
                self._take_plan(report)
            case Found(nearest=nearest):
                self.nearest = nearest
                self._panel.offer_nearest(nearest.changes)
                self._panel.show_status(
                    "Failed", f"{self._failure} It works with {nearest.changes}."
                )
            case Simulated(rollout=rollout):
                self._stage.show_rollout(rollout)
                self._panel.show_status(*summaries.simulated_line(rollout))
            case Failed():
                self._fail(report, task)
            case Cancelled():
                self._tell_cancelled(task)

    def _tell_progress(self, report: Progress) -> None:
        match self._awaited:
            case SimulateJump():
                told = f"({report.text}) ..." if report.share is None else f"{report.share:.0%}"
                self._panel.show_status("Simulating", told, busy=True)
            case FindNearest():
                self._panel.show_status("Failed", f"{self._failure} ({report.text}) ...", busy=True)
            case _:
                self._panel.show_status("Planning", summaries.progress_line(report), busy=True)

    def _tell_cancelled(self, task: Task | None) -> None:
        match task:
            case SimulateJump():
                self._panel.show_status("Cancelled", "The plan is still there.")
            case FindNearest():
                self._panel.show_status("Cancelled", "The search for a jump that works.")
            case _:
                self._live.forget()
                self._panel.show_status("Cancelled", "Move a slider to plan again.")

    def _show_plan(self, report: Planned, *, moving: bool) -> bool:
        """Whether it was shown: not after a newer one, and not of another robot."""
        if report.job < self._shown_job or report.plan.jump.robot != self._stage.robot:
            return False
        self._shown_job = report.job
        self._stage.show_plan(report.plan, moving=moving)
        return True

    def _take_plan(self, report: Planned) -> None:
        moving = not self._live.settled
        if not self._show_plan(report, moving=moving):
            return
        if moving:
            self._panel.show_status("Planning", summaries.live_line(report.plan), busy=True)
            return
        self._panel.show_status("Planned", summaries.planned_line(report.plan))
        self._planned()

    def _fail(self, report: Failed, task: Task | None) -> None:
        match task:
            case FindNearest():
                # Why there is no such jump is told beside what stopped the one that was asked for.
                self._panel.show_status("Failed", f"{self._failure} {report.message}")
            case PlanJump(patient=False):
                # It rests before it is looked at with patience; a hand may still be moving.
                self._panel.show_status("Planning", "nothing found quickly ...", busy=True)
            case PlanJump(jump, tuning) if report.plan is not None:
                self._failure = f"{report.message}."
                if presentable(report.plan):
                    self._stage.show_plan(report.plan)
                    self._failure += (
                        " The picture shows where the solver stopped, no feasible motion."
                    )
                self._submit(FindNearest(jump, tuning))
                self._panel.show_status(
                    "Failed", f"{self._failure} Looking for the nearest jump ...", busy=True
                )
            case _:
                if isinstance(task, PlanJump):
                    self._live.forget()
                self._panel.show_status("Failed", report.message)
