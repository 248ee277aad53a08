"""Feet that jump up do not run into the edge of what they land on."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from llsrbm.motion.plan import Phase
from llsrbm.planning.constraints.base import Array, Bounds, Constraint, spread
from llsrbm.planning.constraints.swing import clearance_line
from llsrbm.planning.headings import direction
from llsrbm.planning.layout import Layout, Role
from llsrbm.planning.stage import Stage

if TYPE_CHECKING:
    from llsrbm.planning.knots import Knots
    from llsrbm.planning.task import Task

# How far corners of soles below the landing surface may come nearer to it than they stood at the
# start, m: its edge may be anywhere in between, but they are there at lift-off.
ROOM = 0.005
# Points have more room: the edge is in the middle between start and target, and they keep so far
# from there, m: a foot's radius and as much again.
APART = 0.035
FAR = 10.0  # m, no bound; finite, see `Constraint.bounds`
# How far feet are above the upper surface before they may be over the edge, m.
ABOVE = 0.02


class Edge(Constraint):
    """Feet cross the edge between start and target above the higher of the two.

    Soles are long: of a jump 0.2 m forward only centimetres lie between where the toes start and
    where the heels land. Seen along `Task.towards`, across the edge, no corner of a foot that jumps
    up comes nearer than the foremost one stands, of points half of the gap, up to the knot where
    `Clearance` has lifted the feet above the surface; and none that jumps down lags behind by more,
    from the knot on where it may sink below the start. A foot whose place the other surface
    overlaps has no edge before it.
    """

    name = "edge"
    unit = "m"

    def applies(self, role: Role) -> bool:
        """Between lift-off and touchdown."""
        return role.phase == Phase.FLIGHT and not role.first

    def rows(self, stage: Stage) -> Any:
        """(C, 1) m: how far each corner is along `towards`."""
        layout = stage.layout
        directions = ca.reshape(stage.parameters["towards"], 2, -1)
        R = stage.R_world_base
        if layout.foot_coordinates == 3:
            feet = (
                stage.position[:2] + ca.mtimes(R[:2, :], stage.foot_from_com(i))
                for i in range(layout.legs)
            )
            return ca.vertcat(*(ca.dot(directions[:, i], foot) for i, foot in enumerate(feet)))
        corners = ca.reshape(stage.parameters["corners"], 2, -1)
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
        """Behind the edge while the feet are low on the way up, beyond it on the way down."""
        step = 1 / layout.intervals.flight
        low, high = self._range(task, layout.progress[knot : knot + 1], step)
        return np.repeat(low[0], layout.corners), np.repeat(high[0], layout.corners)

    def violation(self, knots: Knots) -> Array:
        """Metres too near."""
        inner = slice(knots.flight.start + 1, knots.flight.stop - 1)
        span = knots.flight.stop - knots.flight.start - 1
        low, high = self._range(knots.task, np.arange(1, span) / span, 1 / span)
        legs = knots.model.legs
        corners = knots.contact_point[inner, :, :2].reshape(span - 1, legs, -1, 2)
        along = np.einsum("klcj,lj->klc", corners, knots.task.towards)
        return spread(knots, inner, np.maximum(low[..., None] - along, along - high[..., None]))

    @staticmethod
    def _range(task: Task, s: Array, step: float) -> tuple[Array, Array]:
        """(K, L) m each: bounds at progress s (K,); far where there is no edge to mind."""
        legs = len(task.start_feet)
        start, goal = (
            np.einsum("lcj,lj->lc", points[:, :2].reshape(legs, -1, 2), task.towards)
            for points in (task.start_contacts, task.goal_contacts)
        )
        room = np.maximum(ROOM, task.gap / 2 - APART) if task.foot.is_point else np.full(legs, ROOM)
        surface = max(task.start_feet[:, 2].max(), task.goal_feet[:, 2].max()) + ABOVE
        edge = task.towards.any(axis=1) & (task.jump.height != 0)
        up = edge & (task.jump.height > 0)
        rising = (clearance_line(task, s - step) < surface) & (s[:, None] < 0.5 + step) & up
        sinking = clearance_line(task, s + step) < surface
        sinking = sinking & (s[:, None] > 0.5 - step) & (edge & ~up)
        return (
            np.where(sinking, goal.min(axis=1) - room, -FAR),
            np.where(rising, start.max(axis=1) + room, FAR),
        )
