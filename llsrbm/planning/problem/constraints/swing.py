"""Height and speed of flying feet."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from llsrbm.planning.problem.constraints.base import Array, Bounds, Constraint, Limit
from llsrbm.planning.problem.layout import Layout, Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Task


def ground_line(start: Array, goal: Array, progress: Array) -> Array:
    """m: height that a foot must clear at a share of its swing.

    A landing surface above the start is cleared as high as it is from half way on, one below it is
    not sunk to before, so that no foot meets the edge of what it lands on or leaves.

    Args:
        start, goal: m, heights of where it stood and will stand.
        progress: share of the swing; all of shapes that broadcast to one.
    """
    s = np.asarray(progress)
    u = np.minimum(1.0, np.where(goal > start, 2 * s, 2 * (1 - s)))
    low, high = np.minimum(start, goal), np.maximum(start, goal)
    line: Array = low + (high - low) * u**2 * (3 - 2 * u)
    return line


def clearance_line(task: Task, phase: int, progress: Array) -> Array:
    """(K, L) m: the ground line and an arch of the robot file's clearance above it.

    The arch begins and ends level, because feet leave the ground and meet it at rest. Feet that are
    under way below it come back to it until they land.

    Args:
        task: where feet stand, and the clearance.
        phase: of the schedule; progress: (K, L) share of each foot's swing, of what is left of it
            where that is under way.
    """
    start, goal = task.stood(phase).feet[:, 2], task.lands(phase).feet[:, 2]

    def line(s: Array) -> Array:
        return ground_line(start, goal, s) + (4 * s * (1 - s)) ** 2 * task.limits.clearance

    height = line(task.swing_share(phase, progress))
    if task.motion is not None and phase == 0:
        below = np.maximum(line(task.motion.begun) - task.motion.heights, 0.0)
        height = height - below * (1 - progress)
    return height


class Clearance(Constraint):
    """p_z,i >= ground line + (4 s (1 - s))^2 clearance over the flight."""

    name = "clearance"
    unit = "m"
    by_knot = True
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
        return role.flies

    def rows(self, stage: Stage) -> Any:
        """(flying, 1) m."""
        up_base = stage.lift(stage.R_world_base[2, :].T)
        heights = [
            stage.position[2] + ca.dot(up_base, stage.foot_from_com(i)) for i in stage.role.flying
        ]
        return ca.vertcat(*heights)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """At least the line."""
        role = layout.roles[knot]
        flying = list(role.flying)
        line = clearance_line(task, role.phase, layout.swing_progress[0][[knot]])[0]
        return line[flying], np.full(len(flying), np.inf)


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
        """While feet swing; not as a motion that is under way begins: that is as it is."""
        return bool(role.swinging) and not role.initial

    def rows(self, stage: Stage) -> Any:
        """(3 swinging, 1) m/s."""
        return ca.vec(stage.foot_velocity_base)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Plus and minus the limit."""
        top = np.full(3 * len(layout.roles[knot].swinging), task.limits.foot_speed)
        return -top, top
