"""The computing process: plans and simulates, one job at a time, and reports what comes of it."""

from __future__ import annotations

import signal
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Protocol

from app.protocol import (
    Cancelled,
    Failed,
    Job,
    Planned,
    Planner,
    PlannerFactory,
    Prepare,
    Prepared,
    Progress,
    Ready,
    Report,
    Simulated,
    SimulateJump,
)
from llsrbm import errors
from llsrbm.jump import Jump
from llsrbm.trajectory.plan import Plan
from llsrbm.trajectory.rollout import Conditions, Rollout


class SharedNumber(Protocol):
    """An integer both processes see (`multiprocessing.Value`)."""

    value: int


class LibraryPlanner:
    """Planner and simulator of the library, for robots found by name."""

    def __init__(self) -> None:
        """Import what takes long, once, before the first job."""
        import llsrbm

        self._plan = llsrbm.plan
        self._simulate = llsrbm.simulate
        self._solvers: set[tuple[str, str]] = set()

    def prepare(self, robot: str, progress: Callable[[str], None]) -> None:
        """See `app.protocol.Planner.prepare`."""
        from llsrbm.robots import load_robot
        from llsrbm.robots.visuals import link_visuals

        progress(f"fitting the legs of {robot}")
        loaded = load_robot(robot)
        loaded.fit  # noqa: B018  # computed on first use, then kept on disk
        progress(f"simplifying the meshes of {robot}")
        link_visuals(loaded)

    def plan(
        self, jump: Jump, progress: Callable[[str], None], cancelled: Callable[[], bool]
    ) -> Plan:
        """See `app.protocol.Planner.plan`."""
        which = (jump.robot, jump.model)
        if which not in self._solvers:
            progress(
                f"building the solver of {jump.model} for {jump.robot}: "
                "half a minute, the first time"
            )
        try:
            return self._plan(jump, progress=progress, cancelled=cancelled)
        finally:
            self._solvers.add(which)

    def simulate(
        self,
        plan: Plan,
        conditions: Conditions,
        progress: Callable[[float], None],
        cancelled: Callable[[], bool],
    ) -> Rollout:
        """See `app.protocol.Planner.simulate`."""
        return self._simulate(
            plan,
            board=conditions.board,
            half_board=conditions.half_board,
            seed=conditions.seed,
            noise=None if conditions.seed is None else conditions.noise,
            progress=progress,
            cancelled=cancelled,
        )


def main(connection: Connection, cancelled_up_to: SharedNumber, factory: PlannerFactory) -> None:
    """Work until the server closes its end of the connection.

    An exception that is no `llsrbm.errors.Error` is a defect: it ends the process with a traceback
    in the terminal, which the server notices and tells the user.

    Args:
        connection: jobs come in, reports go out.
        cancelled_up_to: jobs with this number or a smaller one need no result any more.
        factory: makes the planner.
    """
    # Ctrl-C reaches every process of the terminal; the server decides when this one ends.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        planner = factory()
        connection.send(Ready())
        while True:
            job: Job = connection.recv()
            connection.send(_work(planner, job, connection, cancelled_up_to))
    except (EOFError, BrokenPipeError, ConnectionResetError):
        return


def _work(
    planner: Planner, job: Job, connection: Connection, cancelled_up_to: SharedNumber
) -> Report:
    def progress(text: str) -> None:
        connection.send(Progress(job.number, text))

    told = -1

    def percent(share: float) -> None:
        # A simulation tells every tick; whoever looks at it reads whole percents.
        nonlocal told
        if int(100 * share) > told:
            told = int(100 * share)
            connection.send(Progress(job.number, f"simulating, {told} %", share))

    def cancelled() -> bool:
        return cancelled_up_to.value >= job.number

    task = job.task
    try:
        if isinstance(task, Prepare):
            planner.prepare(task.robot, progress)
            return Prepared(job.number, task.robot)
        if isinstance(task, SimulateJump):
            rollout = planner.simulate(task.plan, task.conditions, percent, cancelled)
            return Simulated(job.number, rollout)
        return Planned(job.number, planner.plan(task.jump, progress, cancelled))
    except errors.Cancelled:
        return Cancelled(job.number)
    except errors.NotConverged as error:
        return Failed(job.number, str(error), error.plan)
    except errors.Error as error:
        return Failed(job.number, str(error))
