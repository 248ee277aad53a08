"""The interface of the computing part: `Planner`, made once in each computing process."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from app.workers.opened_file import OpenedFile
from app.workers.protocol import (
    ExportMotion,
    FindNearest,
    Nearest,
    OpenFile,
    PlanJump,
    SimulateJump,
)
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout

Array = NDArray[np.float64]


class ProgressListener(Protocol):
    """Takes the progress of the job that is being worked on; see `Progress`."""

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


SoFarListener = Callable[[float, Array, Array], None]
"""Takes share, instants and states of a simulation that runs; see `SimulatedSoFar`."""


class Planner(Protocol):
    """Made once in each process and kept, its solvers warm.

    Methods call `cancelled` now and then and stop when it is true.
    """

    def prepare(self, robot: str, progress: ProgressListener) -> None:
        """Compute or load everything that drawing `robot` needs.

        Raises:
            llsrbm.errors.Error: the robot cannot be used.
        """
        ...

    def plan(
        self, task: PlanJump, progress: ProgressListener, cancelled: Callable[[], bool]
    ) -> Plan:
        """Plan a jump.

        Raises:
            llsrbm.errors.Error: bad request, no convergence (`NotConverged`), or stopped
                (`Cancelled`).
        """
        ...

    def nearest(
        self, task: FindNearest, progress: ProgressListener, cancelled: Callable[[], bool]
    ) -> Nearest:
        """Find the nearest jump that can be planned.

        Raises:
            llsrbm.errors.Error: bad request, there is none, or stopped (`Cancelled`).
        """
        ...

    def simulate(
        self,
        task: SimulateJump,
        progress: ProgressListener,
        so_far: SoFarListener,
        cancelled: Callable[[], bool],
    ) -> Rollout:
        """Simulate a plan; progress comes with the share that is done.

        Raises:
            llsrbm.errors.Error: the plan or the scenario cannot be used, or stopped
                (`Cancelled`).
        """
        ...

    def open(self, task: OpenFile, progress: ProgressListener) -> OpenedFile:
        """Read a file, and prepare its robot.

        Raises:
            llsrbm.errors.Error: one line that says why it cannot be opened.
        """
        ...

    def export(self, task: ExportMotion, progress: ProgressListener) -> tuple[str, bytes]:
        """Name and content of the file that is made.

        Raises:
            llsrbm.errors.Error: a format cannot hold it, or its packages are missing.
        """
        ...


PlannerFactory = Callable[[], Planner]
"""Makes the planner inside a process; an importable function or class, found there by name."""
