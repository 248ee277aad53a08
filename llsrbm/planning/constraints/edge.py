"""Feet that jump up do not run into the edge of what they land on."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from llsrbm.planning.constraints.base import Array, Bounds, Constraint, spread
from llsrbm.planning.constraints.swing import clearance_line
from llsrbm.planning.headings import direction
from llsrbm.planning.layout import Layout, Role
from llsrbm.planning.stage import Stage
from llsrbm.trajectory.plan import Phase

if TYPE_CHECKING:
    from llsrbm.planning.knots import Knots
    from llsrbm.planning.task import Task

# How far feet below the landing surface may come nearer to it than they stood at the start, m: its
# edge may be anywhere in between, but they are there at lift-off, and a solver needs some room.
ROOM = 0.005
FAR = 10.0  # m, no bound; finite, see `Constraint.bounds`
# How far feet are above the surface before they come nearer, m.
ABOVE = 0.02


class Edge(Constraint):
    """Corners of soles stay behind the edge of a higher landing surface until they are above it.

    Soles are long: of a jump 0.2 m forward only centimetres lie between where the toes start and
    where the heels land. Seen along `Task.towards`, in which the target lies ahead of a foot, none
    of its corners comes nearer than the foremost one stands, up to the knot where `Clearance` has
    lifted the feet above the surface. A foot whose place the target overlaps has no edge before it.
    Points are left to `Clearance` alone.
    """

    name = "edge"
    unit = "m"

    def applies(self, role: Role) -> bool:
        """Between lift-off and touchdown."""
        return role.phase == Phase.FLIGHT and not role.first

    def rows(self, stage: Stage) -> Any:
        """(C, 1) m: how far each corner is along `towards`."""
        layout = stage.layout
        if layout.foot_coordinates == 3:
            return ca.SX(0, 1)
        corners = ca.reshape(stage.parameters["corners"], 2, -1)
        directions = ca.reshape(stage.parameters["towards"], 2, -1)
        R = stage.R_world_base
        columns = []
        for i in range(layout.legs):
            ahead, towards = stage.lift(direction(R, stage.relative_yaw(i))), directions[:, i]
            middle = stage.position[:2] + ca.mtimes(R[:2, :], stage.foot_from_com(i))
            along = ca.dot(towards, ahead)
            aside = towards[1] * ahead[0] - towards[0] * ahead[1]
            columns.append(
                ca.dot(towards, middle) + corners[0, :].T * along + corners[1, :].T * aside
            )
        return ca.vertcat(*columns)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """At most where the foremost corner stands, while the feet are low."""
        if layout.foot_coordinates == 3:
            return np.zeros(0), np.zeros(0)
        step = 1 / layout.intervals.flight
        top = self._top(task, layout.progress[knot : knot + 1], step)[0]
        corners = layout.contacts // layout.legs
        return np.full(layout.contacts, -np.inf), np.repeat(top, corners)

    def violation(self, knots: Knots) -> Array:
        """Metres too near."""
        inner = slice(knots.flight.start + 1, knots.flight.stop - 1)
        if knots.model.coordinates == 3:
            return np.zeros(len(knots.time))
        span = knots.flight.stop - knots.flight.start - 1
        top = self._top(knots.task, np.arange(1, span) / span, 1 / span)
        legs = knots.model.legs
        corners = knots.contact_point[inner, :, :2].reshape(span - 1, legs, -1, 2)
        along = np.einsum("klcj,lj->klc", corners, knots.task.towards)
        return spread(knots, inner, along - top[..., None])

    @staticmethod
    def _top(task: Task, s: Array, step: float) -> Array:
        """(K, L) m: bounds at progress s (K,); none from where the knot before is high enough."""
        surface, ground = task.goal_feet[:, 2].max(), task.start_feet[:, 2]
        low = (clearance_line(task, s - step) < surface + ABOVE) & (s[:, None] < 0.5 + step)
        edge = (surface > ground) & task.towards.any(axis=1)
        corners = task.start_contacts[:, :2].reshape(len(ground), -1, 2)
        foremost = np.einsum("lcj,lj->lc", corners, task.towards).max(axis=1)
        return np.where(low & edge, foremost + ROOM, FAR)
