"""Interface of the constraints: rows for the solver, their bounds, and their violation."""

from abc import ABC, abstractmethod
from typing import Any, ClassVar, NamedTuple

import numpy as np

from llsrbm.arrays import Array
from llsrbm.errors import JointNeed
from llsrbm.planning.problem.knots import Knots
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.limit_table import Limit
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import RowBounds, Task

Bounds = tuple[Any, Any]


class JointDemand(NamedTuple):
    """The largest demand on a joint that a plan may not make, and the interval in which it is."""

    demand: JointNeed
    interval: int


class Constraint(ABC):
    """Rows lower <= rows(stage) <= upper at every stage whose role applies.

    Attributes:
        name: as in reports and files.
        unit: of `violation`.
        equality: whether lower equals upper.
        limits: the numbers in its bounds that a request may change.
        limited_by: names of limits of other constraints that are in its rows, too.
        by_knot: whether the bounds of knots of one role differ.
    """

    name: ClassVar[str]
    unit: ClassVar[str]
    equality: ClassVar[bool] = False
    limits: ClassVar[tuple[Limit, ...]] = ()
    limited_by: ClassVar[tuple[str, ...]] = ()
    by_knot: ClassVar[bool] = False

    def concerns(self, task: Task) -> bool:
        """True if the limits mean something for the task's robot."""
        return True

    def checked(self, task: Task) -> bool:
        """True if plans of a task are checked for it."""
        return True

    @abstractmethod
    def applies(self, role: Role) -> bool:
        """True if stages of that role have these rows."""

    @abstractmethod
    def rows(self, stage: Stage) -> Any:
        """(n, 1) expressions."""

    @abstractmethod
    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Lower and upper bounds of the rows, anything that broadcasts to (n,).

        Which of them are infinite must be the same in all tasks of a robot: Fatrop looks at that
        only in its first solve.
        """

    def violation(self, knots: Knots) -> Array:
        """(N+1,) amount of the violation at or after each knot, in `unit`; 0 when satisfied."""
        out = np.zeros(len(knots.time))
        if (rows := knots.rows.get(self)) is not None:
            lower, value, upper = (
                self.measured(x, knots.task) for x in (rows.lower, rows.values, rows.upper)
            )
            with np.errstate(invalid="ignore"):  # of a solver that diverged
                np.maximum.at(out, rows.knot, np.maximum(lower - value, value - upper))
        return out

    def measured(self, rows: Array, task: Task) -> Array:
        """Rows (n,), or their bounds, in `unit`."""
        return rows

    def demand(self, knots: Knots) -> JointDemand | None:
        """The largest demand on a joint beyond the limits; None if there is none."""
        return None

    def leaning(self, knots: Knots, knot: int, value: float) -> JointNeed | None:
        """The joint that leans on a limit of `value` most, at or after a knot; None: no joint."""
        return None


class AgreedConstraint(Constraint):
    """Rows that are approximations of what the check finds in the whole body.

    Where the check objects their bounds are shifted by what the two differ.
    """

    def checked(self, task: Task) -> bool:
        """True where a draft is to agree with the whole body."""
        return task.agrees

    @abstractmethod
    def agreed_bounds(self, knots: Knots) -> RowBounds:
        """Bounds of the rows at which the check holds, if the two differ as in this motion."""


def spread(knots: Knots, amounts: Array) -> Array:
    """(N+1,) the largest at each knot, never negative, of (N+1, ...) or of intervals (N, ...)."""
    out = np.zeros(len(knots.time))
    out[: len(amounts)] = amounts.reshape(len(amounts), -1).max(axis=1, initial=0.0)
    return out
