"""Reports: messages of the computing processes about their jobs.

A job's reports are any number of partial ones (`Progress`, `SimulatedSoFar`, `SeedDone`), then one
outcome, and nothing after it. `job` is the job's number.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from app.panel.status import SeedResult
from app.workers.opened_file import OpenedFile
from llsrbm.arrays import Array
from llsrbm.certificate import Certificate
from llsrbm.largest_jump import Largest
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.repairing.result import Repair
from llsrbm.request.jump import Jump


@dataclass(frozen=True)
class Ready:
    """A process has started and waits for its first job."""


@dataclass(frozen=True)
class Heavy:
    """A process holds more memory than it should; its job's outcome follows."""


@dataclass(frozen=True)
class Progress:
    """A job is under way, or waits."""

    job: int
    text: str  # one line to show: the work in hand, or the reason for waiting
    share: float | None = None  # done of this very job, 0 to 1; None where that is not known
    # of the solver in this job's running attempt; None where there is none
    iteration: int | None = None
    residual: float | None = None  # the largest constraint violation there, in the solver's scaling
    waiting: bool = False  # it has not begun
    lasts: float | None = None  # s from now on, about; None where that is not known


@dataclass(frozen=True, eq=False)
class SimulatedSoFar:
    """The motion of a simulation that still runs, from its beginning: K instants at about 60 Hz.

    Each report holds everything so far, so that older ones may be dropped.
    """

    job: int
    share: float  # done of it, 0 to 1
    time: Array  # (K,) s from 0 on
    qpos: Array  # (K, 7 + J) in MuJoCo's convention, joints in `Robot.joint_names`' order


@dataclass(frozen=True)
class SeedDone:
    """One more seed of several was simulated: its result, and `done` of `of` by now."""

    job: int
    result: SeedResult
    done: int
    of: int


@dataclass(frozen=True)
class Prepared:
    """A robot, by its name, can be drawn."""

    job: int
    robot: str


@dataclass(frozen=True)
class Planned:
    """A jump was planned and satisfies its constraints."""

    job: int
    plan: Plan


@dataclass(frozen=True)
class Refused:
    """A jump cannot be planned; the nearest that can."""

    job: int
    jump: Jump  # that was asked for
    reason: str  # one sentence, without its full stop
    last: Plan  # the last iterate
    nearest: Plan | None = None  # None: none is known


@dataclass(frozen=True, eq=False)
class FoundLargest:
    """The largest jump in one direction was found."""

    job: int
    largest: Largest


@dataclass(frozen=True)
class Simulated:
    """A plan was followed; whether the robot stands at the end is in the outcome."""

    job: int
    rollout: Rollout


@dataclass(frozen=True, eq=False)
class SimulatedSeeds:
    """A plan was followed once with each seed."""

    job: int
    results: tuple[SeedResult, ...]  # in the order of the task's seeds
    # rollout of the seed that ended worst (`app.workers.seeds.badness`); its scenario has the seed
    worst: Rollout


@dataclass(frozen=True, eq=False)
class Opened:
    """A file was read, and its content can be shown."""

    job: int
    file: OpenedFile


@dataclass(frozen=True, eq=False)
class Exported:
    """A motion was written: name and content of the file."""

    job: int
    name: str
    content: bytes


@dataclass(frozen=True, eq=False)
class Checked:
    """A motion was checked."""

    job: int
    certificate: Certificate


@dataclass(frozen=True, eq=False)
class Repaired:
    """A motion was repaired, or could not be, and why."""

    job: int
    repair: Repair


@dataclass(frozen=True)
class Failed:
    """The job ended without a result: one line for the user."""

    job: int
    message: str


@dataclass(frozen=True)
class Cancelled:
    """The job was stopped because the user requested it."""

    job: int


Partial = Progress | SimulatedSoFar | SeedDone
Outcome = (
    Prepared
    | Planned
    | Refused
    | FoundLargest
    | Simulated
    | SimulatedSeeds
    | Opened
    | Exported
    | Checked
    | Repaired
    | Failed
    | Cancelled
)
Report = Partial | Outcome
Message = Ready | Heavy | Report
Listener = Callable[[Report], None]


@dataclass(frozen=True)
class Talk:
    """The way of a job's partial reports, and of the request to stop it."""

    job: int
    send: Callable[[Report], object]
    stop: Any  # shared with the server, its `value`: number of the job that shall stop

    def progress(
        self,
        text: str,
        *,
        share: float | None = None,
        iteration: int | None = None,
        residual: float | None = None,
        lasts: float | None = None,
    ) -> None:
        """Report `Progress`; cheap enough to be called often."""
        self.send(Progress(self.job, text, share, iteration, residual, lasts=lasts))

    def so_far(self, share: float, time: Array, qpos: Array) -> None:
        """Report `SimulatedSoFar`."""
        self.send(SimulatedSoFar(self.job, share, time, qpos))

    def briefly(self, report: Report) -> None:
        """Report what is not the motion so far."""
        if not isinstance(report, SimulatedSoFar):
            self.send(report)

    def cancelled(self) -> bool:
        """Whether the job shall stop."""
        return bool(self.stop.value == self.job)
