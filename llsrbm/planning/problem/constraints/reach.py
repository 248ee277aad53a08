"""Where feet can be: from their hips, and from each other."""

from itertools import combinations
from typing import Any

import casadi as ca
import numpy as np

from llsrbm.arrays import Array
from llsrbm.planning.problem.constraints.base import Bounds, Constraint
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.limit_table import limits_called
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Task


class Reach(Constraint):
    """l_min <= |x_i| <= l_max from the hip, and a box about it in the hip's mirrored axes.

    The paper bounds the distance from the CoM (section IV-C), which excludes ANYmal's own default
    posture; what a leg reaches is centred at its hip.
    """

    name = "reach"
    unit = "m"
    limits = limits_called(
        "reach_min",
        "reach_max",
        "reach_standing",
        "reach_x_min",
        "reach_x_max",
        "reach_y_min",
        "reach_y_max",
        "reach_z_min",
        "reach_z_max",
    )

    def applies(self, role: Role) -> bool:
        """Wherever the posture is free."""
        return not role.terminal and not role.initial

    def rows(self, stage: Stage) -> Any:
        """(4 L, 1): |x_i|^2 and x_i."""
        columns = []
        for x in ca.horzsplit(stage.feet_in_hip[:3, :]):
            columns += [ca.sumsqr(x), x]
        return ca.vertcat(*columns)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """The robot file's [reach]; of standing feet, hips no lower than its share."""
        reach = task.reach
        lower = np.array([reach.distance[0] ** 2, *reach.lower])
        upper = np.tile([reach.distance[1] ** 2, *reach.upper], (layout.legs, 1))
        standing = list(layout.roles[knot].standing)
        upper[standing, 3] = np.minimum(upper[standing, 3], -task.lowest_hips)
        return np.tile(lower, layout.legs), upper.ravel()

    def measured(self, rows: Array, task: Task) -> Array:
        """m: |x_i| in place of its square."""
        of_legs = rows.reshape(-1, 4).copy()
        of_legs[:, 0] = np.sqrt(of_legs[:, 0])
        return of_legs.ravel()


class FeetApart(Constraint):
    """Any two feet stay apart seen from above the base."""

    name = "feet_apart"
    unit = "m"
    limits = limits_called("feet_apart")

    def applies(self, role: Role) -> bool:
        """Between lift-off and touchdown of any foot."""
        return role.flies

    def rows(self, stage: Stage) -> Any:
        """(pairs, 1): squared distances, m2, of two feet of which one flies."""
        model = stage.model
        feet = [
            (ca.DM(h) + ca.DM(M) * x)[:2]
            for h, M, x in zip(
                model.hips, model.mirrors, ca.horzsplit(stage.feet_in_hip[:3, :]), strict=True
            )
        ]
        pairs = _pairs(stage.layout.legs, stage.role)
        return ca.vertcat(*(ca.sumsqr(feet[i] - feet[j]) for i, j in pairs))

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """At least the square of the distance."""
        pairs = len(_pairs(layout.legs, layout.roles[knot]))
        return np.full(pairs, task.limits.feet_apart**2), np.full(pairs, np.inf)

    def measured(self, rows: Array, task: Task) -> Array:
        """m."""
        return np.sqrt(rows)


def _pairs(legs: int, role: Role) -> list[tuple[int, int]]:
    """Pairs of feet of which at least one flies."""
    return [(i, j) for i, j in combinations(range(legs), 2) if {i, j} & set(role.flying)]
