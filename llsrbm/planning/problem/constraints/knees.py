"""Knees of standing legs keep above what their feet stand on, and swinging legs apart."""

from typing import Any

import casadi as ca
import numpy as np

from llsrbm.arrays import Array
from llsrbm.body.knee_room import knee_room, knee_width
from llsrbm.body.trunk_and_knees import knee_joint
from llsrbm.planning.problem.constraints.base import Bounds, Constraint
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.limit_table import limits_called
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Task

_RISING = 1 / 3  # of the margin, before flights


class KneeHeight(Constraint):
    """z_knee - z_foot >= thickness + margin, of legs that stand in the first or the last phase.

    And of those on which a body leans that is to turn over. The thickness is that of the thigh at
    its knee. In simulations legs bend deeper than planned as they land: knees come up to 45 mm
    lower (Go2), 70 mm (ANYmal); before flights a share of the margin is enough. Motions under way
    keep to it too: without, ANYmal's thighs lay on the ground after each of 12 replanned pushes.
    """

    name = "knee_height"
    unit = "m"
    limits = limits_called("knee_margin")

    def concerns(self, task: Task) -> bool:
        """True if the robot has knees."""
        return knee_joint(task.robot) is not None

    def applies(self, role: Role) -> bool:
        """Where a foot stands in the first or the last phase, or a body leans: others are short."""
        outer = role.final or role.phase == 0 or role.leans
        return outer and bool(role.standing) and not role.terminal and not role.initial

    def rows(self, stage: Stage) -> Any:
        """(standing, 1) m above the foot's contact point; none of robots without knees."""
        model, rows = stage.model, []
        up = stage.lift(stage.R_world_base[2, :].T)
        for i in stage.role.standing:
            knee = model.drives.legs[i].knee(stage.feet_in_hip[:, i])
            if knee is not None:
                seen = stage.offset + ca.DM(model.hips[i]) + stage.lift(knee)
                rows.append(stage.position[2] + ca.dot(up, seen) - stage.standing_feet[2, i])
        return ca.vertcat(*rows) if rows else ca.SX(0, 1)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """At least the thickness and the margin."""
        role = layout.roles[knot]
        rows = len(role.standing) if self.concerns(task) else 0
        margin = task.limits.knee_margin * (1.0 if role.final else _RISING)
        return np.full(rows, knee_room(task.robot) + margin), np.full(rows, np.inf)


class LegsApart(Constraint):
    """y_left - y_right >= 2 width + margin, of knees and feet of legs side by side, base axes.

    At least one of the legs swings. The width is that of the shank at its knee. For a body that
    turns over, which draws its legs in, also x_front - x_hind of legs on one side, of the knee or
    foot of one against the foot or knee of the other.
    """

    name = "legs_apart"
    unit = "m"
    limits = limits_called("legs_apart")

    def concerns(self, task: Task) -> bool:
        """True if the robot has knees."""
        return knee_joint(task.robot) is not None

    def applies(self, role: Role) -> bool:
        """Between lift-off and touchdown of any foot."""
        return role.flies

    def rows(self, stage: Stage) -> Any:
        """(2 (pairs + pairs in a row), 1) m; none of robots without knees."""
        model, rows = stage.model, []
        side_by_side, in_a_row = _pairs(model.hips, stage.layout, stage.role)
        for pairs, axis, crossed in ((side_by_side, 1, False), (in_a_row, 0, True)):
            for pair in pairs:
                x = [stage.feet_in_hip[:, i] for i in pair]
                knees: list[Any] = [
                    model.drives.legs[i].knee(x) for i, x in zip(pair, x, strict=True)
                ]
                if knees[0] is None:
                    continue
                feet = [ca.DM(model.mirrors[i]) * x[:3] for i, x in zip(pair, x, strict=True)]
                if crossed:
                    knees, feet = [knees[0], feet[1]], [feet[0], knees[1]]
                between = float(model.hips[pair[0]][axis] - model.hips[pair[1]][axis])
                for one, other in (knees, feet):
                    rows.append(between + stage.lift(one[axis] - other[axis]))
        return ca.vertcat(*rows) if rows else ca.SX(0, 1)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """At least both widths and the margin."""
        pairs = sum(map(len, _pairs(task.robot.hips, layout, layout.roles[knot])))
        rows = 2 * pairs if self.concerns(task) else 0
        return np.full(rows, 2 * knee_width(task.robot) + task.limits.legs_apart), np.full(
            rows, np.inf
        )


def _pairs(hips: Array, layout: Layout, role: Role) -> tuple[list[tuple[int, int]], ...]:
    """Left leg and the right leg next to it; front leg and the hind leg behind it, if it turns.

    Of each pair at least one flies.
    """
    found: list[list[tuple[int, int]]] = []
    for axis in (1, 0) if layout.turns else (1,):
        ahead, behind = (np.flatnonzero(side * hips[:, axis] > 0) for side in (1, -1))
        if len(behind) == 0:  # of bipeds none is in front
            found.append([])
            continue
        beside = np.abs(hips[ahead][:, None] - hips[behind])[..., 1 - axis]
        pairs = [(int(i), int(behind[row.argmin()])) for i, row in zip(ahead, beside, strict=True)]
        found.append([pair for pair in pairs if set(pair) & set(role.flying)])
    return tuple(found) if layout.turns else (found[0], [])
