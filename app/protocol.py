"""What the server and its computing process say to each other.

Every job has a number, larger than that of any job before it. The process works on one job at a
time, so "stop everything up to job n" is unambiguous and needs no reset.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from llsrbm.jump import Jump
from llsrbm.trajectory.plan import Plan
from llsrbm.trajectory.rollout import Conditions, Rollout

# ---- tasks, server to process


@dataclass(frozen=True)
class Prepare:
    """Compute or load whatever a robot needs before it can be drawn.

    Attributes:
        robot: its name.
    """

    robot: str


@dataclass(frozen=True)
class PlanJump:
    """Plan a jump.

    Attributes:
        jump: the request.
    """

    jump: Jump


@dataclass(frozen=True, eq=False)
class SimulateJump:
    """Follow a plan with the whole robot.

    Attributes:
        plan: a solved one.
        conditions: board and disturbance.
    """

    plan: Plan
    conditions: Conditions


Task = Prepare | PlanJump | SimulateJump


@dataclass(frozen=True)
class Job:
    """One task to work on.

    Attributes:
        number: of the job.
        task: what to do.
    """

    number: int
    task: Task


# ---- reports, process to server


@dataclass(frozen=True)
class Ready:
    """The process has started and waits for its first job."""


@dataclass(frozen=True)
class Progress:
    """What the process is doing now.

    Attributes:
        job: number of the job that waits for it.
        text: one line to show.
        share: done of this very job, 0 to 1; None where that is not known.
    """

    job: int
    text: str
    share: float | None = None


@dataclass(frozen=True)
class Prepared:
    """A robot can be drawn.

    Attributes:
        job: number of the job.
        robot: its name.
    """

    job: int
    robot: str


@dataclass(frozen=True)
class Planned:
    """A jump was planned and satisfies its constraints.

    Attributes:
        job: number of the job.
        plan: the result.
    """

    job: int
    plan: Plan


@dataclass(frozen=True)
class Simulated:
    """A plan was followed; whether the robot stands at the end is in the outcome.

    Attributes:
        job: number of the job.
        rollout: the result.
    """

    job: int
    rollout: Rollout


@dataclass(frozen=True)
class Failed:
    """The job ended without a result.

    Attributes:
        job: number of the job.
        message: one line for the user.
        plan: the last iterate, when there is one to look at.
    """

    job: int
    message: str
    plan: Plan | None = None


@dataclass(frozen=True)
class Cancelled:
    """The job was stopped because the user asked for it.

    Attributes:
        job: number of the job.
    """

    job: int


Report = Progress | Prepared | Planned | Simulated | Failed | Cancelled


# ---- what the process computes with


class Planner(Protocol):
    """The computing part, made once in the process and kept, its solvers warm."""

    def prepare(self, robot: str, progress: Callable[[str], None]) -> None:
        """Compute or load what drawing `robot` needs.

        Raises:
            llsrbm.errors.Error: the robot cannot be used.
        """
        ...

    def plan(
        self, jump: Jump, progress: Callable[[str], None], cancelled: Callable[[], bool]
    ) -> Plan:
        """Plan `jump`, asking `cancelled` now and then whether to stop.

        Raises:
            llsrbm.errors.Error: bad request, no convergence (`NotConverged`), or stopped
                (`Cancelled`).
        """
        ...

    def simulate(
        self,
        plan: Plan,
        conditions: Conditions,
        progress: Callable[[float], None],
        cancelled: Callable[[], bool],
    ) -> Rollout:
        """Simulate `plan`, telling `progress` the share done, 0 to 1.

        Raises:
            llsrbm.errors.Error: the plan or the conditions cannot be used, or stopped
                (`Cancelled`).
        """
        ...


PlannerFactory = Callable[[], Planner]
"""Makes the planner inside the process; an importable function or class, found there by name."""
