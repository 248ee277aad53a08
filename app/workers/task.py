"""A task as the pool sees it: its kind, what has to be built for it, and how it is worked on."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable
from enum import Enum
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Kind(Enum):
    """Kinds of jobs; a tab has one of each running at a time."""

    PLAN = "plan"
    SEARCH = "search"
    SIMULATE = "simulate"
    EXPORT = "export"
    QUICK_EXPORT = "quick export"
    READ = "read"

    @property
    def long(self) -> bool:
        """Whether it may last seconds, and keeps away from the reserved process."""
        return self in (Kind.SEARCH, Kind.SIMULATE, Kind.EXPORT, Kind.READ)

    @property
    def gives_way(self) -> bool:
        """Whether it is stopped at once when its tab requests something newer."""
        return self in (Kind.SEARCH, Kind.SIMULATE, Kind.EXPORT)


class Talk(Protocol):
    """The way of a job's partial reports, and of the request to stop it."""

    def progress(
        self,
        text: str,
        *,
        share: float | None = None,
        iteration: int | None = None,
        residual: float | None = None,
    ) -> None:
        """Report `Progress`; cheap enough to be called often."""
        ...

    def so_far(self, share: float, time: Array, qpos: Array) -> None:
        """Report `SimulatedSoFar`."""
        ...

    def cancelled(self) -> bool:
        """Whether the job shall stop."""
        ...


class Task(ABC):
    """Some work for a process."""

    # it needs files of the server's machine: its meshes, a visitor's file, packages
    only_here: ClassVar[bool] = False
    one_at_a_time: ClassVar[bool] = False  # in the whole pool
    # time (s) that it may take; None: as long as it gives signs of life
    limit: ClassVar[float | None] = None

    @property
    @abstractmethod
    def kind(self) -> Kind:
        """Its kind."""

    @property
    def needs(self) -> Hashable:
        """The robot or the solver that has to be built first; None: nothing."""
        return None

    @property
    def parts(self) -> tuple[Task, ...]:
        """Tasks that processes work on side by side, in place of this one; it alone: not so."""
        return (self,)

    @abstractmethod
    def work(self, planner: Any, job: int, talk: Talk) -> Any:
        """Have the planner of this process do it; the outcome (`app.workers.protocol`).

        Raises:
            llsrbm.errors.Error: it cannot be done, or was stopped (`Cancelled`).
        """
