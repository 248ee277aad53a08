"""How much of a request may be given up."""

from __future__ import annotations

from typing import Any

import numpy as np

from llsrbm.planning.problem.constraints.base import Array, Bounds, Constraint
from llsrbm.planning.problem.elastic import (
    GIVE_UP,
    ElasticLayout,
    ElasticRole,
    elastic_parameters,
)
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Task

ROOM = 2e-3  # of a range beyond all of a component: an interior-point solver needs an interior


class GivenUp(Constraint):
    """0 <= s <= all of it, of each component of the request; elastic problems alone."""

    name = "given_up"
    unit = "1"

    def applies(self, role: Role) -> bool:
        """Where it is chosen."""
        return isinstance(role, ElasticRole) and role.gives_up

    def checked(self, task: Task) -> bool:
        """Never: a plan that was found does all of its own jump."""
        return False

    def rows(self, stage: Stage) -> Any:
        """(4, 1) shares of the ranges."""
        return stage.symbols[GIVE_UP]

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """At most down to nothing."""
        assert isinstance(layout, ElasticLayout)
        top = most(layout, task)
        return np.zeros_like(top), top + ROOM


def most(layout: ElasticLayout, task: Task) -> Array:
    """(4,) all that can be given up of a request, in shares of the ranges."""
    numbers = elastic_parameters(layout, task)
    wanted, scale = np.abs(numbers["asked"]), np.abs(numbers["scale"])
    top: Array = np.divide(wanted, scale, out=np.zeros_like(wanted), where=scale > 0)
    return top
