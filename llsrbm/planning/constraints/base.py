"""What a constraint is: rows for the solver, their bounds, and a check of the finished plan."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from llsrbm.planning.knots import Knots
from llsrbm.planning.layout import Layout, Role
from llsrbm.planning.stage import Stage
from llsrbm.planning.task import Task

Array = NDArray[np.float64]


Bounds = tuple[Any, Any]


class Constraint(ABC):
    """Rows lower <= rows(stage) <= upper at every stage whose role applies.

    Attributes:
        name: as in reports and files.
        unit: of `violation`.
        equality: whether lower equals upper.
    """

    name: ClassVar[str]
    unit: ClassVar[str]
    equality: ClassVar[bool] = False

    @abstractmethod
    def applies(self, role: Role) -> bool:
        """Whether stages of that role have these rows."""

    @abstractmethod
    def rows(self, stage: Stage) -> Any:
        """(n, 1) expressions."""

    @abstractmethod
    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Lower and upper bounds of the rows, anything that broadcasts to (n,).

        Which of them are infinite must be the same in all tasks of a robot: Fatrop looks at that
        only in its first solve.
        """

    @abstractmethod
    def violation(self, knots: Knots) -> Array:
        """(N+1,) amount of the violation at or after each knot, in `unit`; 0 when satisfied."""


def spread(knots: Knots, where: slice, amounts: Array) -> Array:
    """(N+1,) with the largest of `amounts`, (n, ...), at the knots `where`; never negative."""
    out = np.zeros(len(knots.time))
    flat = amounts.reshape(len(amounts), -1)
    out[where] = flat.max(axis=1, initial=0.0)
    return out


def everywhere(knots: Knots) -> slice:
    """All knots."""
    return slice(0, len(knots.time))
