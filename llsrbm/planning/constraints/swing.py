"""How feet fly: above the ground, and no faster than legs can carry them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from llsrbm.motion.plan import Phase
from llsrbm.planning.constraints.base import Array, Bounds, Constraint, Limit, spread
from llsrbm.planning.layout import Layout, Role
from llsrbm.planning.stage import Stage

if TYPE_CHECKING:
    from llsrbm.planning.knots import Knots
    from llsrbm.planning.task import Task


def ground_line(task: Task, progress: Array) -> Array:
    """(K, L) m: height that feet must clear at `progress` (K,) of the flight.

    A landing surface above the start is cleared as high as it is from half way on, one below it is
    not sunk to before, so that no foot meets the edge of what it lands on or leaves.
    """
    s = np.asarray(progress)[:, None]
    start, goal = task.start_feet[:, 2], task.goal_feet[:, 2]
    u = np.minimum(1.0, np.where(goal > start, 2 * s, 2 * (1 - s)))
    low, high = np.minimum(start, goal), np.maximum(start, goal)
    return low + (high - low) * u**2 * (3 - 2 * u)


def clearance_line(task: Task, progress: Array) -> Array:
    """(K, L) m: the ground line and an arch of the robot file's clearance above it.

    The arch begins and ends level, because feet leave the ground and meet it at rest.
    """
    arch = (4 * progress * (1 - progress)) ** 2 * task.limits.clearance
    return ground_line(task, progress) + arch[:, None]


class Clearance(Constraint):
    """p_z,i >= ground line + (4 s (1 - s))^2 clearance over the flight."""

    name = "clearance"
    unit = "m"
    limits = (
        Limit(
            "clearance",
            "clearance of the feet",
            "m",
            "feet are lifted higher in mid-flight",
            lowest=0.0,
            highest=0.3,
            place=("limits", "clearance"),
            lower_bound=True,
        ),
    )

    def applies(self, role: Role) -> bool:
        """Between lift-off and touchdown."""
        return role.phase == Phase.FLIGHT and not role.first

    def rows(self, stage: Stage) -> Any:
        """(L, 1) m."""
        up_base = stage.lift(stage.R_world_base[2, :].T)
        heights = [
            stage.position[2] + ca.dot(up_base, stage.foot_from_com(i))
            for i in range(stage.layout.legs)
        ]
        return ca.vertcat(*heights)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """At least the line."""
        line = clearance_line(task, layout.progress[knot : knot + 1])[0]
        return line, np.full(layout.legs, np.inf)

    def violation(self, knots: Knots) -> Array:
        """Metres below the line."""
        inner = slice(knots.flight.start + 1, knots.flight.stop - 1)
        span = knots.flight.stop - knots.flight.start - 1
        line = clearance_line(knots.task, np.arange(1, span) / span)
        return spread(knots, inner, line - knots.foot_position[inner][..., 2])


class FootSpeed(Constraint):
    """The feet's speed in the world along each base axis."""

    name = "foot_speed"
    unit = "m/s"
    limits = (
        Limit(
            "foot_speed",
            "foot speed over the ground",
            "m/s",
            "feet may fly faster over the ground",
            lowest=0.2,
            highest=3.0,
            place=("limits", "foot_speed"),
            relative=True,
        ),
    )

    def applies(self, role: Role) -> bool:
        """In flight."""
        return role.phase == Phase.FLIGHT

    def rows(self, stage: Stage) -> Any:
        """(3 L, 1) m/s."""
        return ca.vec(stage.foot_velocity_base)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Plus and minus the limit."""
        top = np.full(3 * layout.legs, task.limits.foot_speed)
        return -top, top

    def violation(self, knots: Knots) -> Array:
        """Speed beyond the limit."""
        excess = np.abs(knots.foot_velocity_base) - knots.task.limits.foot_speed
        return spread(knots, slice(knots.flight.start, knots.flight.stop - 1), excess)
