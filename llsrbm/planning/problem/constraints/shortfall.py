"""How much of a request may be given up."""

from typing import Any

import numpy as np

from llsrbm.arrays import Array
from llsrbm.planning.problem.constraints.base import Bounds, Constraint
from llsrbm.planning.problem.layout import NEXT_SHORTFALL, Layout
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.shortfall import shortfall_parameters
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Task

ROOM = 2e-3  # of a range beyond all of a component: an interior-point solver needs an interior


class Shortfall(Constraint):
    """0 <= s <= all of it, of each component of the request."""

    name = "shortfall"
    unit = "1"

    def applies(self, role: Role) -> bool:
        """Where it is chosen."""
        return role.chooses_shortfall

    def checked(self, task: Task) -> bool:
        """Never: a plan that was found does all of its own jump."""
        return False

    def rows(self, stage: Stage) -> Any:
        """(4, 1) shares of the ranges."""
        return stage.symbols[NEXT_SHORTFALL]

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """At most down to nothing."""
        top = most(layout, task)
        return np.zeros_like(top), top + ROOM


def most(layout: Layout, task: Task) -> Array:
    """(4,) all that can be given up of a request, in shares of the ranges."""
    numbers = shortfall_parameters(layout, task)
    whole, scale = np.abs(numbers["asked"]), np.abs(numbers["scale"])
    return np.divide(whole, scale, out=np.zeros_like(whole), where=scale > 0)
