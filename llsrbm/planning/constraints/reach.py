"""Where feet can be: from their hips, and from each other."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import casadi as ca
import numpy as np

from llsrbm.planning.constraints.base import Array, Bounds, Constraint, spread
from llsrbm.planning.knots import Knots
from llsrbm.planning.layout import Layout, Role
from llsrbm.planning.stage import Stage
from llsrbm.planning.task import Task
from llsrbm.trajectory.plan import Phase


class Reach(Constraint):
    """l_min <= |x_i| <= l_max from the hip, and a box about it in the hip's mirrored axes.

    The paper bounds the distance from the CoM (section IV-C), which excludes ANYmal's own default
    posture; what a leg reaches is centred at its hip.
    """

    name = "reach"
    unit = "m"

    def applies(self, role: Role) -> bool:
        """Wherever the posture is free."""
        return not role.terminal and not (role.phase == Phase.TAKEOFF and role.first)

    def rows(self, stage: Stage) -> Any:
        """(4 L, 1): |x_i|^2 and x_i."""
        columns = []
        for x in ca.horzsplit(stage.feet_in_hip[:3, :]):
            columns += [ca.sumsqr(x), x]
        return ca.vertcat(*columns)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """The robot file's [reach]."""
        reach = task.reach
        lower = [reach.distance[0] ** 2, *reach.lower]
        upper = [reach.distance[1] ** 2, *reach.upper]
        return np.tile(lower, layout.legs), np.tile(upper, layout.legs)

    def violation(self, knots: Knots) -> Array:
        """Metres beyond the distance or the box."""
        reach, x = knots.task.reach, knots.feet_in_hip[1:-1, :, :3]
        distance = np.linalg.norm(x, axis=-1, keepdims=True)
        beyond = np.concatenate(
            [
                reach.distance[0] - distance,
                distance - reach.distance[1],
                np.array(reach.lower) - x,
                x - np.array(reach.upper),
            ],
            axis=-1,
        )
        return spread(knots, slice(1, len(knots.time) - 1), beyond)


class FeetApart(Constraint):
    """Any two feet stay apart seen from above the base."""

    name = "feet_apart"
    unit = "m"

    def applies(self, role: Role) -> bool:
        """Between lift-off and touchdown."""
        return role.phase == Phase.FLIGHT and not role.first

    def rows(self, stage: Stage) -> Any:
        """(L (L - 1) / 2, 1): squared distances, m2."""
        model = stage.model
        feet = [
            (ca.DM(h) + ca.DM(M) * x)[:2]
            for h, M, x in zip(
                model.hips, model.mirrors, ca.horzsplit(stage.feet_in_hip[:3, :]), strict=True
            )
        ]
        return ca.vertcat(*(ca.sumsqr(a - b) for a, b in combinations(feet, 2)))

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """At least the square of the distance."""
        pairs = layout.legs * (layout.legs - 1) // 2
        return np.full(pairs, task.limits.feet_apart**2), np.full(pairs, np.inf)

    def violation(self, knots: Knots) -> Array:
        """Metres too close."""
        inner = slice(knots.flight.start + 1, knots.flight.stop - 1)
        model = knots.model
        feet = (model.hips + model.mirrors * knots.feet_in_hip[inner, :, :3])[..., :2]
        gaps = [
            np.linalg.norm(feet[:, i] - feet[:, j], axis=-1)
            for i, j in combinations(range(model.legs), 2)
        ]
        return spread(knots, inner, knots.task.limits.feet_apart - np.stack(gaps, axis=1))
