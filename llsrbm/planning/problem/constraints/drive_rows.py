"""Rows of the joints' drives, and how their bounds follow what the whole body says.

The rows take torques and speeds from closed forms or fits (`llsrbm.models.leg_drives`): in the
middle of each interval, and at lift-off and touchdown, where standing legs are fastest. The check
recomputes them with Pinocchio: inverse dynamics of the whole body in the postures that realise the
plan (`llsrbm.body.joint_loads`). Where it objects, the rows' bounds are shifted by what they differ
from it (`agreed_bounds`).
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from llsrbm.body.joint_loads import JointLoads
from llsrbm.body.peak_loads import event_beside, when_in_words
from llsrbm.errors import JointNeed
from llsrbm.planning.problem.constraints.base import AgreedConstraint, Array, Bounds, spread
from llsrbm.planning.problem.knots import Knots
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import RowBounds, Task

# Beyond so many times the limit rows grow with its root: near a straight leg shares of thousands
# come up on the way to a solution, and slopes of millions, with which Fatrop may look for a
# direction for ever. At the limit 0.2 % are left out.
FAR_BEYOND = 10.0
# Of what the check allows shifted bounds keep this share of the limit, since the difference changes
# with the motion, and more where the check has objected before: a share of the excess, and this.
RESERVE = 0.006
AGAIN, AGAIN_SHARE = 0.003, 0.7
# Shifted bounds leave the rows this much on either side.
LEAST = 0.03
# By no more of a limit they are shifted, or a motion that is far from a solution would close them;
# of arms by more, whose drives are weak against what a landing asks of them over one interval.
MOST, MOST_OF_ARMS = 0.5, 1.0

MIDDLE, EDGE = 0, 1  # where over an interval, in arrays (N, 2, J)
Place = tuple[int, int, int]  # in one


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
        return tamed(ca.vertcat(ca.vec(self.shares(stage)), self.arm_shares(stage)))

    @abstractmethod
    def shares(self, stage: Stage) -> Any:
        """(n, L + touching_down + beside a swing) what is bounded."""

    @abstractmethod
    def arm_shares(self, stage: Stage) -> Any:
        """(A n, 1) likewise, of free arms."""

    @abstractmethod
    def tops(self, task: Task) -> Array:
        """(2,) the bounds of rows in the middle of an interval and at its edge."""

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Plus and minus the share, or where the whole body keeps to it."""
        legs = task.robot.leg_joint_index
        landing, beside = self._further_legs(layout.roles[knot])
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
            return tamed(lower, np.sqrt), tamed(upper, np.sqrt)
        middle, edge = self.tops(task) * [1.0, 1.0 - self.edge_reserve]
        tops = np.repeat([middle, edge, middle], [len(joints), len(edges), len(arms)])
        top = tamed(tops, np.sqrt)
        return -top, top

    def violation(self, knots: Knots) -> Array:
        """By Pinocchio, over each interval."""
        return spread(knots, self.excess(knots))

    def excess(self, knots: Knots) -> Array:
        """(N, 2, J) in the constraint's unit; below zero where there is room, or no edge."""
        top = self.tops(knots.task) + self.allowance(knots)
        excess = (np.abs(self.checked_shares(knots)) - top[:, None]) / self.share_of(knots)
        return of_planned(_of_edges(excess), knots)

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
        """Bounds of the rows at which the check holds, if the two differ as in this motion."""
        both = _swings_on(knots) & self.of_both_ends
        rows, settled = self._row_shares(knots)
        after = np.where(both, rows[1:], rows[:-1])
        after[:, MIDDLE] = np.where(np.isnan(settled), after[:, MIDDLE], settled)
        here = (rows[:-1] + after) / 2
        most = np.full(knots.task.joints, MOST)
        most[knots.task.free_arms] = MOST_OF_ARMS
        beyond = np.nan_to_num(self.checked_shares(knots) - here).clip(-most, most)
        known = knots.task.agreed_bounds.get(self.name)
        reserve = np.zeros_like(rows)
        if known is not None:
            excess = self.excess(knots) * self.share_of(knots)
            more = np.where(excess > 0, AGAIN_SHARE * excess + AGAIN, 0.0)
            reserve = known.reserve + _on_rows(more, both, np.maximum)
        top = self.tops(knots.task)[:, None]
        edge = top + self.allowance(knots)[:, None] - reserve
        upper = np.minimum(top, edge - RESERVE - _on_rows(beyond, both, np.maximum))
        lower = np.maximum(-top, RESERVE - edge - _on_rows(beyond, both, np.minimum))
        return RowBounds(np.minimum(lower, -LEAST), np.maximum(upper, LEAST), reserve)

    def leaning(self, knots: Knots, knot: int, value: float) -> JointNeed | None:
        """The joint with the largest share over the interval."""
        interval, robot = min(knot, len(knots.dt) - 1), knots.task.robot
        shares = np.abs(self.checked_shares(knots)[interval]) / self.tops(knots.task)[:, None]
        if np.isnan(shares).all():
            return None
        where, joint = np.unravel_index(np.nanargmax(shares), shares.shape)
        place = interval, int(where), int(joint)
        has, unit = self._has(knots, place, value)
        return JointNeed(robot.joint_names[joint], has, has, unit, when_in(knots.loads, interval))

    @abstractmethod
    def _has(self, knots: Knots, place: Place, value: float) -> tuple[float, str]:
        """Amount and unit of what a joint may use under a limit of `value`."""

    def _row_shares(self, knots: Knots) -> tuple[Array, Array]:
        """(N+1, 2, J) by the rows, and (N, J) as the last interval of a swing ends; else NaN."""
        legs, arms = knots.task.robot.leg_joint_index, knots.task.free_arms
        shares = np.full((len(knots.time), 2, knots.task.joints), np.nan)
        settled = np.full((len(knots.dt), knots.task.joints), np.nan)
        if (rows := knots.rows.get(self)) is not None:
            for knot in np.unique(rows.knot):
                values = _untamed(rows.values[rows.knot == knot])
                landing, beside = self._further_legs(knots.layout.roles[knot])
                ends, edges = legs[list(landing)].ravel(), legs[list(beside)].ravel()
                parts = np.split(values, np.cumsum([legs.size, ends.size, edges.size]))
                shares[knot, MIDDLE, legs.ravel()] = parts[0]
                shares[knot, EDGE, edges] = parts[2]
                shares[knot, MIDDLE, arms] = parts[3]
                if knot < len(settled):
                    settled[knot, ends] = parts[1]
        return shares, settled

    def _further_legs(self, role: Role) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Legs that have rows for a swing's end, and for lift-off or touchdown, after all legs'."""
        return (
            role.touching_down if self.of_both_ends else (),
            role.at_edge if self.of_edges else (),
        )


def tamed(share: Any, root: Callable[[Any], Any] = ca.sqrt) -> Any:
    """A share, or its bound, as a row: increasing, and far beyond the limit ever slower."""
    return share / root(root(1 + (share / FAR_BEYOND) ** 2))


def _untamed(row: Array) -> Array:
    """The share that a row is of."""
    fourth = row**4
    square = fourth / FAR_BEYOND**2
    share: Array = np.sign(row) * np.sqrt((square + np.sqrt(square**2 + 4 * fourth)) / 2)
    return share


def _swings_on(knots: Knots) -> NDArray[np.bool_]:
    """(N, 2, J) joints of limbs that swing over an interval and the next one.

    Their rows are as an interval begins, the check is in its middle.
    """
    swings = ~knots.layout.standing[:-1]
    on = swings & np.vstack([swings[1:], np.zeros_like(swings[:1])])
    joints = np.zeros((len(on), 2, knots.task.joints), dtype=bool)
    for leg, mine in enumerate(knots.task.robot.leg_joint_index):
        joints[:, MIDDLE, mine] = on[:, [leg]]
    # Arms swing on in every phase, but what carries the base changes from one to the next.
    same = np.append((swings[1:] == swings[:-1]).all(axis=1), False)
    joints[:, MIDDLE, knots.task.free_arms] = same[:, None]
    return joints


def _on_rows(amounts: Array, both: NDArray[np.bool_], larger: np.ufunc) -> Array:
    """(N+1, 2, J) for the rows of amounts (N, 2, J); `both` belong to the next row too."""
    rows = np.vstack([amounts, np.zeros_like(amounts[:1])])
    rows[1:] = np.where(both, larger(rows[1:], amounts), rows[1:])
    return rows


def at_middle_and_edge(middle: Array, edge: Array) -> Array:
    """(N, 2, J) of (N, J) each."""
    return np.stack([middle, edge], axis=1)


def of_planned(excess: Array, knots: Knots) -> Array:
    """(N, 2, J) likewise with room where arms are held."""
    excess[..., knots.task.held_arms] = -np.inf
    return excess


def _of_edges(excess: Array) -> Array:
    """(N, 2, J) likewise with room where there is no edge."""
    excess[:, EDGE] = np.fmax(excess[:, EDGE], -np.inf)
    return excess


def when_in(loads: JointLoads, interval: int) -> str:
    """An interval, in words."""
    phase = loads.schedule[int(loads.phase[interval])].name
    return when_in_words(phase, loads.time[interval], event_beside(loads.contact, interval))
