"""Feet that jump up do not run into the edge of what they land on."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from llsrbm.planning.problem.constraints.base import Array, Bounds, Constraint
from llsrbm.planning.problem.constraints.swing import clearance_line
from llsrbm.planning.problem.layout import Layout, Role
from llsrbm.planning.problem.rotations import direction
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Task

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
    by_knot = True

    def applies(self, role: Role) -> bool:
        """Between lift-off and touchdown."""
        return role.flies

    def rows(self, stage: Stage) -> Any:
        """(flying contacts, 1) m: how far each corner is along `towards`."""
        layout, directions, flying = stage.layout, stage.towards, stage.role.flying
        R = stage.R_world_base
        if layout.foot_coordinates == 3:
            feet = [
                stage.position[:2] + ca.mtimes(R[:2, :], stage.foot_from_com(i)) for i in flying
            ]
            along = zip(flying, feet, strict=True)
            return ca.vertcat(*(ca.dot(directions[:, i], foot) for i, foot in along))
        corners = ca.reshape(stage.parameters["corners"], 2, -1)
        columns = []
        for i in flying:
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
        flying = list(layout.roles[knot].flying)
        low, high = (values[knot, flying] for values in _ranges(task, layout))
        return np.repeat(low, layout.corners), np.repeat(high, layout.corners)


@lru_cache(maxsize=2)
def _ranges(task: Task, layout: Layout) -> tuple[Array, Array]:
    """(N + 1, L) m each: `_range` of all knots."""
    progress, step = layout.swing_progress
    low, high = np.full((2, *progress.shape), np.nan)
    for phase in range(layout.phases):
        here = layout.phase == phase
        low[here], high[here] = _range(task, phase, progress[here], step[here])
    return low, high


def _range(task: Task, phase: int, progress: Array, step: Array) -> tuple[Array, Array]:
    """(K, L) m each: bounds of corners along `towards`; far where there is no edge to mind.

    Args:
        task: where feet stand.
        phase: of the schedule.
        progress, step: (K, L) share of each foot's swing, and the share an interval takes.
    """
    legs = range(len(task.schedule.legs))
    towards = task.towards(phase)
    stood, lands = task.stood(phase), task.lands(phase)
    start, goal = (
        np.einsum("lcj,lj->lc", place.contacts[:, :2].reshape(len(legs), -1, 2), towards)
        for place in (stood, lands)
    )
    edges = [task.edges(phase, i) for i in legs]
    gap = np.array([edge.gap[i] for i, edge in zip(legs, edges, strict=True)])
    rise = np.array([edge.rise for edge in edges])
    room = np.maximum(ROOM, gap / 2 - APART) if task.foot.is_point else np.full(len(legs), ROOM)
    surface = np.maximum(stood.feet[:, 2].max(), lands.feet[:, 2].max()) + ABOVE
    edge = towards.any(axis=1) & (rise != 0)
    up = edge & (rise > 0)
    share = task.swing_share(phase, progress)
    rising = clearance_line(task, phase, progress - step) < surface
    rising = rising & (share < 0.5 + step) & up
    sinking = clearance_line(task, phase, progress + step) < surface
    sinking = sinking & (share > 0.5 - step) & (edge & ~up)
    return (
        np.where(sinking, goal.min(axis=1) - room, -FAR),
        np.where(rising, start.max(axis=1) + room, FAR),
    )
