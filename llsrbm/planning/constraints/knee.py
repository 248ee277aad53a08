"""How fast legs fold."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from llsrbm.planning.constraints.base import Array, Bounds, Constraint, Limit, spread
from llsrbm.planning.layout import Layout, Role
from llsrbm.planning.stage import Stage
from llsrbm.trajectory.plan import Phase

if TYPE_CHECKING:
    from llsrbm.planning.knots import Knots
    from llsrbm.planning.task import Task

# Share of the joint speed limit that the knee may use at an interval's midpoint. The rest is for
# the speed it gains up to the interval's end (push-off: about 10 %) and for the hip abduction,
# which moves the hip joint a little (about 10 %).
KNEE_SHARE = 0.75


class KneeSpeed(Constraint):
    """The knee's speed, from how fast the foot comes nearer to the hip or moves away.

    A leg of thigh a and shank b that is l long folds with l ldot = a b sin(theta) thetadot and
    a^2 b^2 sin^2(theta) = a^2 b^2 - ((a^2 + b^2 - l^2) / 2)^2, so that |thetadot| <= limit reads

        (x . xdot)^2 / limit^2 + ((a^2 + b^2 - |x|^2) / 2)^2 <= a^2 b^2,

    a polynomial, also where the leg is nearly straight. The knee is the fastest joint of a jump,
    and fastest at the end of the push-off and at the start of the landing: within the stance phases
    the rows, which are expensive there, are written for these two intervals alone. Legs that do
    not fold at a knee are left free.
    """

    name = "knee_speed"
    unit = "rad/s"
    limits = (
        Limit(
            "knee_speed",
            "speed of the knee",
            "rad/s",
            "legs may fold and stretch faster; the default is 3/4 of the drive's limit",
            lowest=0.3,
            highest=2.0,
            place=("knee_speed",),
            relative=True,
        ),
    )

    def concerns(self, task: Task) -> bool:
        """Legs that fold at a knee."""
        return task.knee is not None

    def applies(self, role: Role) -> bool:
        """In flight, in the last interval before it and in the first one after it."""
        if role.phase == Phase.TAKEOFF:
            return role.last
        return role.phase == Phase.FLIGHT or role.first

    def rows(self, stage: Stage) -> Any:
        """(L, 1), left over right hand side."""
        x, xdot = (rows[:3, :] for rows in stage.feet_mid[:2])
        limit, a, b = (stage.parameters[n] for n in ("knee_speed", "thigh", "shank"))
        columns = [
            (
                (ca.dot(x[:, i], xdot[:, i]) / limit) ** 2
                + ((a**2 + b**2 - ca.sumsqr(x[:, i])) / 2) ** 2
            )
            / (a * b) ** 2
            for i in range(stage.layout.legs)
        ]
        return ca.vertcat(*columns)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """At most 1, if the leg has a knee."""
        top = np.inf if task.knee is None else 1.0
        return np.full(layout.legs, -np.inf), np.full(layout.legs, top)

    def violation(self, knots: Knots) -> Array:
        """Speed beyond the limit at the intervals' midpoints."""
        knee = knots.task.knee
        if knee is None:
            return np.zeros(len(knots.time))
        a, b = knee
        x, xdot = (array[..., :3] for array in knots.feet_mid)
        closing = np.abs(np.sum(x * xdot, axis=-1))
        lever = np.sqrt(
            np.maximum((a * b) ** 2 - ((a**2 + b**2 - np.sum(x * x, axis=-1)) / 2) ** 2, 1e-12)
        )
        excess = closing / lever - knots.task.knee_speed
        where = slice(knots.flight.start - 1, knots.flight.stop)
        return spread(knots, where, excess[where])
