"""Rows of the joints' drives, their bounds and their check.

The rows take torques and speeds from closed forms or fits (`llsrbm.models.leg_drives`): in the
middle of each interval, and at lift-off and touchdown, where standing legs are fastest. The check
recomputes them with Pinocchio: inverse dynamics of the whole body in the postures that realise the
plan (`llsrbm.body.joint_loads`). Where it objects, the rows' bounds are shifted by what they differ
from it (`drive_shifts`); `drive_needs` says which joint a limit stops.
"""

from abc import abstractmethod
from typing import Any, ClassVar

import casadi as ca
import numpy as np

from llsrbm.arrays import Array
from llsrbm.errors import JointNeed
from llsrbm.planning.problem.constraints.base import AgreedConstraint, Bounds, JointDemand, spread
from llsrbm.planning.problem.constraints.drive_needs import largest_demand, leaning_joint
from llsrbm.planning.problem.constraints.drive_shares import (
    EDGE,
    MIDDLE,
    compressed,
    of_edges,
    of_planned,
)
from llsrbm.planning.problem.constraints.drive_shifts import shifted_bounds
from llsrbm.planning.problem.knots import Knots
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import RowBounds, Task


class DriveConstraint(AgreedConstraint):
    """Rows of all joints, symmetric bounds.

    Attributes:
        of_both_ends: whether the last interval of a swing has rows for its end too.
        of_edges: whether standing legs have rows for lift-off and touchdown.
        allowances: shares that the check allows beyond, and those for compared models.
        edge_reserve: share that rows keep there of their bounds until the check is known.
    """

    of_both_ends: ClassVar[bool] = True
    of_edges: ClassVar[bool] = True
    allowances: ClassVar[tuple[float, float]]
    edge_reserve: ClassVar[float] = 0.0

    def rows(self, stage: Stage) -> Any:
        """(n (L + touching_down + beside a swing) + A n, 1)."""
        return compressed(ca.vertcat(ca.vec(self.shares(stage)), self.arm_shares(stage)))

    @abstractmethod
    def shares(self, stage: Stage) -> Any:
        """(n, L + touching_down + beside a swing) what is bounded."""

    @abstractmethod
    def arm_shares(self, stage: Stage) -> Any:
        """(A n, 1) likewise, of free arms."""

    @abstractmethod
    def scale(self, task: Task) -> float:
        """A share of the task's drives, as the rows count it: of those of the robot's file."""

    @abstractmethod
    def tops(self, task: Task) -> Array:
        """(2,) the bounds of rows in the middle of an interval and at its edge."""

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Plus and minus the share, or where the whole body keeps to it."""
        legs = task.robot.leg_joint_index
        landing, beside = self.further_legs(layout.roles[knot])
        joints = np.concatenate([legs.ravel(), legs[list(landing)].ravel()])
        edges, arms = legs[list(beside)].ravel(), task.free_arms
        if self.name in task.agreed_bounds:
            shifted = task.agreed_bounds[self.name]
            lower, upper = (
                np.concatenate(
                    [ends[knot, MIDDLE, joints], ends[knot, EDGE, edges], ends[knot, MIDDLE, arms]]
                )
                for ends in (shifted.lower, shifted.upper)
            )
            scale = self.scale(task)
            return compressed(scale * lower, np.sqrt), compressed(scale * upper, np.sqrt)
        middle, edge = self.scale(task) * self.tops(task) * [1.0, 1.0 - self.edge_reserve]
        tops = np.repeat([middle, edge, middle], [len(joints), len(edges), len(arms)])
        top = compressed(tops, np.sqrt)
        return -top, top

    def violation(self, knots: Knots) -> Array:
        """By Pinocchio, over each interval."""
        return spread(knots, self.excess(knots))

    def excess(self, knots: Knots) -> Array:
        """(N, 2, J) in the constraint's unit; below zero where there is room, or no edge."""
        top = self.tops(knots.task) + self.allowance(knots)
        excess = (np.abs(self.checked_shares(knots)) - top[:, None]) / self.share_of(knots)
        return of_planned(of_edges(excess), knots)

    @abstractmethod
    def checked_shares(self, knots: Knots) -> Array:
        """(N, 2, J) as the rows have them, by Pinocchio; NaN where there is no edge."""

    @abstractmethod
    def share_of(self, knots: Knots) -> Array:
        """(J,) shares, as rows have them, of one in the constraint's unit."""

    def allowance(self, knots: Knots) -> Array:
        """(2,) amounts beyond `tops` that the check allows, as rows have it."""
        own, compared = self.allowances
        return np.full(2, own if knots.model.is_true else compared)

    def agreed_bounds(self, knots: Knots) -> RowBounds:
        """See `shifted_bounds`."""
        return shifted_bounds(self, knots)

    @abstractmethod
    def share(self, task: Task) -> float:
        """The share of the limits that plans may use."""

    @abstractmethod
    def needed(self, knots: Knots) -> Array:
        """(N, 2, J) what joints need, in the constraint's unit; NaN where there is no edge."""

    @abstractmethod
    def allowed(self, knots: Knots, share: float) -> Array:
        """(N, 2, J) what they may use if that is so large a share of their limits."""

    def demand(self, knots: Knots) -> JointDemand | None:
        """See `largest_demand`."""
        return largest_demand(self, knots)

    def leaning(self, knots: Knots, knot: int, value: float) -> JointNeed | None:
        """See `leaning_joint`."""
        return leaning_joint(self, knots, knot, value)

    def further_legs(self, role: Role) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Legs that have rows for a swing's end, and for lift-off or touchdown, after all legs'."""
        return (
            role.touching_down if self.of_both_ends else (),
            role.at_edge if self.of_edges else (),
        )
