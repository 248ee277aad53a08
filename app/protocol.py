"""What the server and its planning process say to each other.

Every job has a number, larger than that of any job before it. The process works on one job at a
time, so "stop everything up to job n" is unambiguous and needs no reset.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from llsrbm.jump import Jump
from llsrbm.trajectory.plan import Plan

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


Task = Prepare | PlanJump


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
    """

    job: int
    text: str


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


Report = Progress | Prepared | Planned | Failed | Cancelled


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


PlannerFactory = Callable[[], Planner]
"""Makes the planner inside the process; an importable function or class, found there by name."""
