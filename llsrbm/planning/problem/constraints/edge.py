"""Feet that jump up do not run into the edge of what they land on."""

from typing import Any

import casadi as ca
import numpy as np

from llsrbm.planning.problem.constraints.base import Bounds, Constraint
from llsrbm.planning.problem.foot_clearance import edge_ranges
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.rotations import direction
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Task


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
            return ca.vertcat(
                *(ca.dot(directions[:, i], foot) - stage.edge_moved(i) for i, foot in along)
            )
        corners = ca.reshape(stage.parameters["corners"], 2, -1)
        columns = []
        for i in flying:
            ahead, towards = stage.lift(direction(R, stage.relative_yaw(i))), directions[:, i]
            middle = stage.position[:2] + ca.mtimes(R[:2, :], stage.foot_from_com(i))
            along = ca.dot(towards, ahead)
            aside = towards[1] * ahead[0] - towards[0] * ahead[1]
            columns.append(
                ca.dot(towards, middle)
                - stage.edge_moved(i)
                + corners[0, :].T * along
                + corners[1, :].T * aside
            )
        return ca.vertcat(*columns)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Behind the edge while the feet are low on the way up, beyond it on the way down."""
        flying = list(layout.roles[knot].flying)
        low, high = (values[knot, flying] for values in edge_ranges(task, layout))
        return np.repeat(low, layout.corners), np.repeat(high, layout.corners)
