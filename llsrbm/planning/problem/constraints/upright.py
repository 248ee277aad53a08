"""A body that has turned over lands upright."""

from __future__ import annotations

from typing import Any

import numpy as np

from llsrbm.planning.problem.constraints.base import Array, Bounds, Constraint
from llsrbm.planning.problem.layout import Layout, Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Task

# How far the base may lean from touchdown on, rad. It comes down at some 10 rad/s, and the legs
# stop that within a tenth of a second at best: half a radian.
LEAN = np.radians(30.0)


class UprightLanding(Constraint):
    """e_z . R e_z >= cos(lean) from touchdown on, of jumps in which the body turns over.

    Others are kept upright by their costs. Without it a flip lands as soon as its front or hind
    feet reach the ground, and turns the rest of the way over them.
    """

    name = "upright_landing"
    unit = "rad"

    def applies(self, role: Role) -> bool:
        """After the last flight; the very end is given."""
        return role.lands_upright and not role.terminal

    def rows(self, stage: Stage) -> Any:
        """(1, 1) the cosine of the lean."""
        return stage.R_world_base[2, 2]

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """At least that of the largest lean."""
        return np.array([np.cos(LEAN)]), np.array([np.inf])

    def measured(self, rows: Array, task: Task) -> Array:
        """Less the lean, rad."""
        return -np.arccos(np.clip(rows, -1.0, 1.0))
