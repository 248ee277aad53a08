"""How feet fly: above the ground, and no faster than legs can carry them."""

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

# A foot's speed may rise to 8 s (1 - s) of its limit over the flight, s = 0 ... 1: full from an
# eighth of the way on, zero at lift-off and touchdown, where the foot stands.
SPEED_RAMP = 8.0


def ground_line(task: Task, progress: Array) -> Array:
    """(K, L) m: height that feet must clear at `progress` (K,) of the flight.

    From the start to the target; a landing surface above the start is cleared as high as it is
    from half way on, so that no foot meets the edge of the box. The rise begins smoothly, as a
    foot's speed does (`SPEED_RAMP`).
    """
    s = np.asarray(progress)[:, None]
    start, goal = task.start_feet[:, 2], task.goal_feet[:, 2]
    straight = start * (1 - s) + goal * s
    u = np.minimum(1.0, 2 * s)
    early = start + (goal - start) * u**2 * (3 - 2 * u)
    return np.where(goal > start, early, straight)


def clearance_line(task: Task, progress: Array) -> Array:
    """(K, L) m: the ground line and an arch of the robot file's clearance above it."""
    arch = 4 * progress * (1 - progress) * task.limits.clearance
    return ground_line(task, progress) + arch[:, None]


def speed_ramp(s: Any) -> Any:
    """Share of a foot's speed limit that is allowed at progress s of the flight."""
    return np.minimum(1.0, SPEED_RAMP * s * (1 - s))


class Clearance(Constraint):
    """p_z,i >= ground line + 4 s (1 - s) clearance over the flight."""

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
    """The feet's speed in the world along each base axis, rising from and falling to rest."""

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
        """Plus and minus the ramped limit at the interval's midpoint."""
        middle = layout.progress[knot] + 0.5 / layout.intervals.flight
        top = np.full(3 * layout.legs, task.limits.foot_speed * speed_ramp(middle))
        return -top, top

    def violation(self, knots: Knots) -> Array:
        """Speed beyond the limit."""
        velocity = knots.foot_velocity_base
        middle = (np.arange(len(velocity)) + 0.5) / len(velocity)
        limit = knots.task.limits.foot_speed * speed_ramp(middle)
        where = slice(knots.flight.start, knots.flight.stop - 1)
        return spread(knots, where, np.abs(velocity) - limit[:, None, None])


class FootSpeedInBase(Constraint):
    """|xdot_i| along each axis in flight: keeps the swing executable by the joints."""

    name = "foot_speed_in_base"
    unit = "m/s"
    limits = tuple(
        Limit(
            f"foot_speed_in_base_{axis}",
            f"foot speed along the base's {axis}",
            "m/s",
            f"feet may swing faster along the base's {axis} in flight",
            lowest=0.2,
            highest=3.0,
            place=("limits", "foot_speed_in_base", index),
            relative=True,
        )
        for index, axis in enumerate("xyz")
    )

    def applies(self, role: Role) -> bool:
        """In flight."""
        return role.phase == Phase.FLIGHT

    def rows(self, stage: Stage) -> Any:
        """(3 L, 1) m/s."""
        return ca.vec(stage.feet_mid[1][:3, :])

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Plus and minus the limit."""
        top = np.tile(task.limits.foot_speed_in_base, layout.legs)
        return -top, top

    def violation(self, knots: Knots) -> Array:
        """Speed beyond the limit."""
        rate = np.abs(knots.flight_feet_rate[..., :3])
        excess = rate - np.array(knots.task.limits.foot_speed_in_base)
        return spread(knots, slice(knots.flight.start, knots.flight.stop - 1), excess)
