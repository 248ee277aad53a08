"""Where feet can be: from their hips, and from each other."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import casadi as ca
import numpy as np

from llsrbm.planning.problem.constraints.base import Array, Bounds, Constraint, Limit
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Task

# The ranges of the box and of the distance stay near the robot file's: the maps of the legs are
# fitted there, and the closed forms of the legs' drives hold there.
_BOX = (
    ("x", "behind their hips (mirrored hind legs: ahead)", "ahead of their hips (those: behind)"),
    ("y", "inward of their hips", "outward of their hips"),
    ("z", "below their hips", "up towards their hips"),
)


class Reach(Constraint):
    """l_min <= |x_i| <= l_max from the hip, and a box about it in the hip's mirrored axes.

    The paper bounds the distance from the CoM (section IV-C), which excludes ANYmal's own default
    posture; what a leg reaches is centred at its hip.
    """

    name = "reach"
    unit = "m"
    limits = (
        Limit(
            "reach_min",
            "shortest leg, hip to foot",
            "m",
            "legs fold less",
            lowest=0.8,
            highest=1.4,
            place=("reach", "distance", 0),
            relative=True,
            lower_bound=True,
        ),
        Limit(
            "reach_max",
            "longest leg, hip to foot",
            "m",
            "legs may stretch further: knees get faster near the straight leg",
            lowest=0.75,
            highest=1.08,
            place=("reach", "distance", 1),
            relative=True,
        ),
        Limit(
            "reach_standing",
            "lowest hips above standing feet",
            "1",
            "robots crouch less before they jump and when they land; a share of standing upright",
            lowest=0.3,
            highest=0.95,
            place=("reach", "standing"),
            lower_bound=True,
        ),
        *(
            Limit(
                f"reach_{axis}_{end}",
                f"{extreme} {axis} of a foot from its hip",
                "m",
                effect,
                lowest=0.4,
                highest=1.25,
                place=("reach", corner, index),
                lower_bound=end == "min",
                relative=True,
            )
            for index, (axis, back, ahead) in enumerate(_BOX)
            for end, extreme, corner, effect in (
                ("min", "lowest", "lower", f"feet come less far {back}"),
                ("max", "highest", "upper", f"feet may come further {ahead}"),
            )
        ),
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
    limits = (
        Limit(
            "feet_apart",
            "distance that feet keep",
            "m",
            "feet stay further from each other in flight: less of a twist comes from the inertia",
            lowest=0.0,
            highest=0.5,
            place=("limits", "feet_apart"),
            lower_bound=True,
        ),
    )

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
