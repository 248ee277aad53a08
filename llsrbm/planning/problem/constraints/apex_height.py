"""How high the centre of mass flies."""

from typing import Any

import numpy as np

from llsrbm.mechanics import GRAVITY
from llsrbm.planning.problem.apex import APEX_LIMITS
from llsrbm.planning.problem.constraints.base import Bounds, Constraint
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.limit_table import limits_called
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Task


class ApexHeight(Constraint):
    """low <= z + v_z^2 / 2 g <= high at every lift-off: in free fall that is the apex."""

    name = "apex_height"
    unit = "m"
    limits = limits_called(*APEX_LIMITS)

    def applies(self, role: Role) -> bool:
        """Where flights begin whose apex is limited."""
        return role.limits_apex

    def rows(self, stage: Stage) -> Any:
        """(1, 1) m above the ground at the start."""
        return stage.position[2] + stage.velocity[2] ** 2 / (2 * GRAVITY)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """The limits."""
        low, high = task.apex
        return np.array([low]), np.array([high])
