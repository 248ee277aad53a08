"""Height and speed of flying feet."""

from typing import Any

import casadi as ca
import numpy as np

from llsrbm.planning.problem.constraints.base import Bounds, Constraint
from llsrbm.planning.problem.foot_clearance import clearance_line
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.limit_table import limits_called
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Task

BESIDE = 0.02  # m that feet of a body that turns over may be beside their place just before


class Clearance(Constraint):
    """p_z,i >= ground line + (4 s (1 - s))^2 clearance over the flight."""

    name = "clearance"
    unit = "m"
    by_knot = True
    limits = limits_called("clearance")

    def applies(self, role: Role) -> bool:
        """Between lift-off and touchdown."""
        return role.flies

    def rows(self, stage: Stage) -> Any:
        """(flying, 1) m."""
        up_base = stage.lift(stage.R_world_base[2, :].T)
        body = stage.position[2] - stage.model.foot_lift
        heights = [
            body + ca.dot(up_base, stage.foot_from_com(i)) - stage.ground_moved(i)
            for i in stage.role.flying
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
    limits = limits_called("foot_speed")

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


class PutDown(Constraint):
    """Feet of a body that turns over come down where they will stand, over the last interval.

    Its feet sweep over the ground at 4 m/s: one that meets it some milliseconds early, or after
    another one, would stand 10 cm beside its place.
    """

    name = "put_down"
    unit = "m"

    def applies(self, role: Role) -> bool:
        """As the last interval of a flight begins."""
        return bool(role.touching_down)

    def rows(self, stage: Stage) -> Any:
        """(2 touching_down, 1) m, horizontal places, less the shift of where they land."""
        if not stage.layout.turns:
            return ca.SX(0, 1)
        shift = stage.shift if stage.role.lands_shifted else ca.SX.zeros(2)
        return ca.vertcat(*(stage.foot_place(i)[:2] - shift for i in stage.role.touching_down))

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Around where they will stand."""
        role = layout.roles[knot]
        feet = list(role.touching_down) if layout.turns else []
        places = task.footholds_after(role.phase).feet[feet, :2].ravel()
        return places - BESIDE, places + BESIDE
