"""What the server and its computing processes say to each other.

Every job has a number of its own, and a process works on one job at a time, so "stop job n" is
unambiguous and needs no reset.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from app.compute.opened_file import OpenedFile
from llsrbm.design import SUFFIX
from llsrbm.formats import find
from llsrbm.jump import Jump
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.scenario import Scenario
from llsrbm.tuning import Tuning

# ---- tasks, server to process

_NUMBERS = {".npz", ".csv", ".json", ".pkl", SUFFIX}  # of files that hold nothing else


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
        tuning: weights and limits in place of the robot's own.
        near: a plan to start from, if it is of use for that: one of the same robot and model that
            converged.
        patient: try all there is when the quick attempts fail.
    """

    jump: Jump
    tuning: Tuning = field(default_factory=Tuning)
    near: Plan | None = None
    patient: bool = True


@dataclass(frozen=True, eq=False)
class SimulateJump:
    """Follow a plan with the whole robot.

    Attributes:
        plan: a solved one.
        scenario: board and disturbance.
    """

    plan: Plan
    scenario: Scenario


@dataclass(frozen=True)
class FindNearest:
    """Find the nearest jump that can be planned.

    Attributes:
        jump: a request that cannot be.
        tuning: weights and limits in place of the robot's own.
    """

    jump: Jump
    tuning: Tuning = field(default_factory=Tuning)


@dataclass(frozen=True, eq=False)
class OpenFile:
    """Read what a visitor sent, and get its robot ready to be drawn.

    Attributes:
        name: of the file, as the browser has it.
        content: of the file.
        robot: whose motion it is, where the file does not say.
        fps: frames/s, likewise; None: it has to say.
    """

    name: str
    content: bytes
    robot: str
    fps: float | None = None


@dataclass(frozen=True, eq=False)
class ExportMotion:
    """Write a plan or a rollout in other formats.

    Attributes:
        trajectory: what to write.
        formats: their names.
        zipped: into one zip, with what describes them; several are in any case.
        options: as `llsrbm.export` takes them.
    """

    trajectory: Plan | Rollout
    formats: tuple[str, ...]
    zipped: bool = False
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def quick(self) -> bool:
        """Whether it surely takes less than a second: numbers alone, no meshes and no pictures."""
        return all(find(name).suffix in _NUMBERS for name in self.formats)


Task = Prepare | PlanJump | FindNearest | SimulateJump | OpenFile | ExportMotion


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


class Nearest(Protocol):
    """What a search finds (`llsrbm.nearest`)."""

    @property
    def jump(self) -> Jump:
        """The one that can be planned."""
        ...

    @property
    def plan(self) -> Plan:
        """Its plan."""
        ...

    @property
    def changes(self) -> str:
        """How it differs from the request, in words."""
        ...


@dataclass(frozen=True)
class Ready:
    """A process has started and waits for its first job."""


@dataclass(frozen=True)
class Progress:
    """What a process is doing now.

    Attributes:
        job: number of the job that waits for it.
        text: one line to show.
        share: done of this very job, 0 to 1; None where that is not known.
        iteration: of the solver in this job's running attempt; None where there is none.
        residual: the largest constraint violation there, in the solver's scaling.
    """

    job: int
    text: str
    share: float | None = None
    iteration: int | None = None
    residual: float | None = None


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
class Found:
    """The nearest jump that can be planned was found.

    Attributes:
        job: number of the job.
        nearest: the jump, its plan and how it differs from the request, in words.
    """

    job: int
    nearest: Nearest


@dataclass(frozen=True)
class Simulated:
    """A plan was followed; whether the robot stands at the end is in the outcome.

    Attributes:
        job: number of the job.
        rollout: the result.
    """

    job: int
    rollout: Rollout


@dataclass(frozen=True, eq=False)
class Opened:
    """A file was read, and what it holds can be shown.

    Attributes:
        job: number of the job.
        file: what it holds.
    """

    job: int
    file: OpenedFile


@dataclass(frozen=True, eq=False)
class Exported:
    """A motion was written.

    Attributes:
        job: number of the job.
        name: of the file.
        content: of the file.
    """

    job: int
    name: str
    content: bytes


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


Report = Progress | Prepared | Planned | Found | Simulated | Opened | Exported | Failed | Cancelled


# ---- what the process computes with


class Tell(Protocol):
    """Takes news of the job that is being worked on; see `Progress`."""

    def __call__(
        self,
        text: str,
        *,
        share: float | None = None,
        iteration: int | None = None,
        residual: float | None = None,
    ) -> None:
        """Pass it on; cheap enough to be called often."""
        ...


class Planner(Protocol):
    """The computing part, made once in each process and kept, its solvers warm.

    `cancelled` is to be asked now and then.
    """

    def prepare(self, robot: str, tell: Tell) -> None:
        """Compute or load what drawing `robot` needs.

        Raises:
            llsrbm.errors.Error: the robot cannot be used.
        """
        ...

    def plan(self, task: PlanJump, tell: Tell, cancelled: Callable[[], bool]) -> Plan:
        """Plan a jump.

        Raises:
            llsrbm.errors.Error: bad request, no convergence (`NotConverged`), or stopped
                (`Cancelled`).
        """
        ...

    def nearest(self, task: FindNearest, tell: Tell, cancelled: Callable[[], bool]) -> Nearest:
        """Find the nearest jump that can be planned.

        Raises:
            llsrbm.errors.Error: bad request, there is none, or stopped (`Cancelled`).
        """
        ...

    def simulate(self, task: SimulateJump, tell: Tell, cancelled: Callable[[], bool]) -> Rollout:
        """Simulate a plan, telling the share done.

        Raises:
            llsrbm.errors.Error: the plan or the scenario cannot be used, or stopped
                (`Cancelled`).
        """
        ...

    def open(self, task: OpenFile, tell: Tell) -> OpenedFile:
        """Read a file, and have what drawing its robot needs.

        Raises:
            llsrbm.errors.Error: one line that says why it cannot be opened.
        """
        ...

    def export(self, task: ExportMotion, tell: Tell) -> tuple[str, bytes]:
        """Name and content of the file that is made.

        Raises:
            llsrbm.errors.Error: a format cannot hold it, or its packages are missing.
        """
        ...


PlannerFactory = Callable[[], Planner]
"""Makes the planner inside a process; an importable function or class, found there by name."""
