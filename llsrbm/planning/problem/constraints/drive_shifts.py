"""How the bounds of drives' rows follow what the whole body says."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from llsrbm.arrays import Array, BoolArray
from llsrbm.planning.problem.constraints.drive_shares import EDGE, MIDDLE, expanded
from llsrbm.planning.problem.knots import Knots
from llsrbm.planning.problem.task import RowBounds

if TYPE_CHECKING:
    from llsrbm.planning.problem.constraints.drive_rows import DriveConstraint

# Of what the check allows shifted bounds keep this share of the limit, since the difference changes
# with the motion, and more where the check has objected before: a share of the excess, and this.
RESERVE = 0.006
AGAIN, AGAIN_SHARE = 0.003, 0.7
# Shifted bounds leave the rows this much on either side.
LEAST = 0.03
# By no more of a limit they are shifted, or a motion that is far from a solution would close them;
# of arms by more, whose drives are weak against what a landing asks of them over one interval.
MOST, MOST_OF_ARMS = 0.5, 1.0


def shifted_bounds(constraint: DriveConstraint, knots: Knots) -> RowBounds:
    """Bounds of the rows at which the check holds, if the two differ as in this motion."""
    both = _swings_on(knots) & constraint.of_both_ends
    rows, settled = _row_shares(constraint, knots)
    after = np.where(both, rows[1:], rows[:-1])
    after[:, MIDDLE] = np.where(np.isnan(settled), after[:, MIDDLE], settled)
    here = (rows[:-1] + after) / 2
    most = np.full(knots.task.joints, MOST)
    most[knots.task.free_arms] = MOST_OF_ARMS
    beyond = np.nan_to_num(constraint.checked_shares(knots) - here).clip(-most, most)
    known = knots.task.agreed_bounds.get(constraint.name)
    reserve = np.zeros_like(rows)
    if known is not None:
        excess = constraint.excess(knots) * constraint.share_of(knots)
        more = np.where(excess > 0, AGAIN_SHARE * excess + AGAIN, 0.0)
        reserve = known.reserve + _on_rows(more, both, np.maximum)
    top = constraint.tops(knots.task)[:, None]
    edge = top + constraint.allowance(knots)[:, None] - reserve
    upper = np.minimum(top, edge - RESERVE - _on_rows(beyond, both, np.maximum))
    lower = np.maximum(-top, RESERVE - edge - _on_rows(beyond, both, np.minimum))
    return RowBounds(np.minimum(lower, -LEAST), np.maximum(upper, LEAST), reserve)


def _row_shares(constraint: DriveConstraint, knots: Knots) -> tuple[Array, Array]:
    """(N+1, 2, J) by the rows, and (N, J) as the last interval of a swing ends; else NaN."""
    legs, arms = knots.task.robot.leg_joint_index, knots.task.free_arms
    shares = np.full((len(knots.time), 2, knots.task.joints), np.nan)
    settled = np.full((len(knots.dt), knots.task.joints), np.nan)
    if (rows := knots.rows.get(constraint)) is not None:
        for knot in np.unique(rows.knot):
            values = expanded(rows.values[rows.knot == knot]) / constraint.scale(knots.task)
            landing, beside = constraint.further_legs(knots.layout.roles[knot])
            ends, edges = legs[list(landing)].ravel(), legs[list(beside)].ravel()
            parts = np.split(values, np.cumsum([legs.size, ends.size, edges.size]))
            shares[knot, MIDDLE, legs.ravel()] = parts[0]
            shares[knot, EDGE, edges] = parts[2]
            shares[knot, MIDDLE, arms] = parts[3]
            if knot < len(settled):
                settled[knot, ends] = parts[1]
    return shares, settled


def _swings_on(knots: Knots) -> BoolArray:
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


def _on_rows(amounts: Array, both: BoolArray, larger: np.ufunc) -> Array:
    """(N+1, 2, J) for the rows of amounts (N, 2, J); `both` belong to the next row too."""
    rows = np.vstack([amounts, np.zeros_like(amounts[:1])])
    rows[1:] = np.where(both, larger(rows[1:], amounts), rows[1:])
    return rows
