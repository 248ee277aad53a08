"""Each constraint is checked over the intervals that have rows for it, and has rows for all."""

from dataclasses import replace

import numpy as np
import pytest

from llsrbm.body.joint_loads import JointLoads
from llsrbm.body.postures import Postures
from llsrbm.planning.problem.constraints import CONSTRAINTS, Constraint
from llsrbm.planning.problem.constraints.truth import CheckAlone
from tests.llsrbm.planning.solved import solved

OWN = [c for c in CONSTRAINTS if type(c).violation is not Constraint.violation]
# Rows at knots bound what is between them, too: the last of a stop's is at the end of an interval.
AT_BOTH_ENDS = {"joint_stops", "body_clearance"}
PLANS = [("all", "anymal"), ("rear-last", "anymal")]


def broken_everywhere(knots):
    """The motion with joints that are too fast, too weak and beyond stops at every knot."""
    loads, postures, other = knots.loads, knots.postures, replace(knots)
    far = {
        name: np.full_like(getattr(loads, name), 1e6)
        for name in ("joint_velocity", "joint_torque", "joint_position")
    }
    edges = np.where(np.isnan(loads.edge_velocity), np.nan, 1e6)
    none = {name: np.zeros_like(loads.joint_torque) for name in ("torque_available",)}
    nothing = np.where(np.isnan(loads.edge_available), np.nan, 0.0)
    vars(other)["loads"] = replace(
        loads, **far, **none, edge_velocity=edges, edge_available=nothing
    )
    vars(other)["postures"] = replace(
        postures, joint_position=np.full_like(postures.joint_position, 1e6)
    )
    return other


def knots_with_rows(constraint, layout):
    """(N+1,) whether a knot has rows of the constraint."""
    return np.array([constraint.applies(role) for role in layout.roles])


def test_the_others_are_checked_by_their_rows():
    """What recomputes its own amounts is known here: another one needs its own comparison."""
    compared = {"joint_torque", "torque_at_speed", "joint_speed", "joint_stops"}
    elsewhere = {"phase_times", "body_clearance"}  # by its rows; in its own tests
    alone = {c.name for c in OWN if isinstance(c, CheckAlone)}
    assert {c.name for c in OWN} == compared | elsewhere | alone
    assert alone == {"true_turn", "rolling", "legs_reach", "turns_over"}  # of the whole body


@pytest.mark.parametrize("which", PLANS, ids=lambda which: "-".join(which))
@pytest.mark.parametrize("name", ["joint_torque", "torque_at_speed", "joint_speed", "joint_stops"])
def test_checked_where_there_are_rows(which, name):
    knots = solved("llsrbm-plus", *which).knots
    assert isinstance(knots.loads, JointLoads)
    assert isinstance(knots.postures, Postures)
    constraint = next(c for c in CONSTRAINTS if c.name == name)
    broken = constraint.violation(broken_everywhere(knots)) > 0
    rows = knots_with_rows(constraint, knots.layout)
    if name in AT_BOTH_ENDS:
        rows[:-1] |= rows[1:]
    np.testing.assert_array_equal(broken, rows)
