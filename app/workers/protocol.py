"""Messages between the server and its computing processes: tasks one way, reports the other.

Every job has a number of its own, and a process works on one job at a time, so "stop job n" is
unambiguous and needs no reset.

A job's reports are any number of partial ones (`Progress`, `SimulatedSoFar`, `SeedDone`), then one
outcome, and nothing after it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from app.workers.opened_file import OpenedFile
from llsrbm.formats import find
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.request.design import SUFFIX
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from llsrbm.request.tuning import Tuning

# ---- tasks, server to process

_NUMBERS = {".npz", ".csv", ".json", ".pkl", SUFFIX}  # of files that hold nothing else


@dataclass(frozen=True)
class Prepare:
    """Compute or load all that drawing a robot needs.

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
        near: a plan to start from, if it is of use for that: one of the same solver that converged.
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


@dataclass(frozen=True, eq=False)
class SimulateSeeds:
    """Follow a plan once with each seed's disturbance, to see how many land.

    Attributes:
        plan: a solved one.
        scenario: board and noise; its own seed does not matter.
        seeds: different ones, in the order in which they are simulated.
    """

    plan: Plan
    scenario: Scenario
    seeds: tuple[int, ...]


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
    """Read a visitor's file, and prepare its robot.

    Attributes:
        name: of the file, as the browser has it.
        content: of the file.
        robot: for files that do not name one.
        fps: frames/s, likewise; None: the file has to state it.
    """

    name: str
    content: bytes
    robot: str
    fps: float | None = None


@dataclass(frozen=True, eq=False)
class ExportMotion:
    """Write a plan or a rollout in other formats.

    Attributes:
        trajectory: to be written.
        formats: their names.
        zipped: into one zip, with a description; several are in any case.
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


Task = Prepare | PlanJump | FindNearest | SimulateJump | SimulateSeeds | OpenFile | ExportMotion

Solver = tuple[str, str, str, int]
"""Requests that one solver works on: robot, model, jump type and hops, which make the phases."""


def solver_of(jump: Jump) -> Solver:
    """The solver that a request needs."""
    return jump.robot, jump.model, jump.type, jump.hops


@dataclass(frozen=True)
class Job:
    """One task to work on.

    Attributes:
        number: of the job.
        task: the work.
    """

    number: int
    task: Task


# ---- reports, process to server


class Nearest(Protocol):
    """Result of a search (`llsrbm.nearest`)."""

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
    """A job is under way, or waits.

    Attributes:
        job: its number.
        text: one line to show: the work in hand, or the reason for waiting.
        share: done of this very job, 0 to 1; None where that is not known.
        iteration: of the solver in this job's running attempt; None where there is none.
        residual: the largest constraint violation there, in the solver's scaling.
    """

    job: int
    text: str
    share: float | None = None
    iteration: int | None = None
    residual: float | None = None


@dataclass(frozen=True, eq=False)
class SimulatedSoFar:
    """The motion of a simulation that still runs, from its beginning: K instants at about 60 Hz.

    Each report holds everything so far, so that older ones may be dropped.

    Attributes:
        job: number of the job.
        share: done of it, 0 to 1.
        time: (K,) s from 0 on.
        qpos: (K, 7 + J) in MuJoCo's convention, joints in `Robot.joint_names`' order.
    """

    job: int
    share: float
    time: NDArray[np.float64]
    qpos: NDArray[np.float64]


@dataclass(frozen=True)
class SeedResult:
    """How the simulation of one seed ended.

    Attributes:
        seed: of its disturbance.
        landed: whether the robot stands at the end.
        strict: whether it landed by the strict measure (`llsrbm.simulation.verdict`).
        fell_at_s: when it fell; None if it landed.
        foot_error: largest horizontal distance of a foot from the plan's at the end, m.
        line: the same in words.
    """

    seed: int
    landed: bool
    strict: bool
    fell_at_s: float | None
    foot_error: float
    line: str


@dataclass(frozen=True)
class SeedDone:
    """One more seed of several was simulated.

    Attributes:
        job: number of the job.
        result: of that seed.
        done, of: how many are done by now, of how many.
    """

    job: int
    result: SeedResult
    done: int
    of: int


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
class SimulatedSeeds:
    """A plan was followed once with each seed.

    Attributes:
        job: number of the job.
        results: in the order of the task's seeds.
        worst: rollout of the seed that ended worst (`app.workers.seeds.badness`); its scenario has
            the seed.
    """

    job: int
    results: tuple[SeedResult, ...]
    worst: Rollout


@dataclass(frozen=True, eq=False)
class Opened:
    """A file was read, and its content can be shown.

    Attributes:
        job: number of the job.
        file: its content.
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


Partial = Progress | SimulatedSoFar | SeedDone
Outcome = (
    Prepared | Planned | Found | Simulated | SimulatedSeeds | Opened | Exported | Failed | Cancelled
)
Report = Partial | Outcome
