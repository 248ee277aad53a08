"""Torques and speeds that the solver bounds, against Pinocchio's of the whole body."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from llsrbm.planning.problem.constraints.drive_shares import FAR_BEYOND, MIDDLE
from llsrbm.planning.problem.constraints.drive_shifts import RESERVE
from llsrbm.planning.problem.constraints.drives import DRIVES
from tests.llsrbm.planning.solved import (
    function,
    parameters,
    rows_by_constraint,
    solved,
)

ANYMALS = [("llsrbm-plus", request, "anymal") for request in ("all", "rear-last")]
BOX = ("llsrbm-plus", "box", "slider")
every_plan = pytest.mark.parametrize("which", [*ANYMALS, BOX], ids=lambda w: f"{w[2]}-{w[1]}")


def shares(rows):
    """What the rows say, without what they leave out of large shares."""
    square = rows**4 / FAR_BEYOND**2
    return np.sign(rows) * np.sqrt((square + np.sqrt(square**2 + 4 * rows**4)) / 2)


@cache
def rows_and_loads(which):
    """Shares (N - 1, J) of torque and {knot: (J,)} of speed by the rows; the same by Pinocchio.

    And pairs of speeds (n,) at lift-off and touchdown, by the rows and by Pinocchio.

    Rows of swinging legs are torques as intervals begin, and as the last one ends; the means of
    both ends belong to the middles, as Pinocchio's. Torques are from the second interval on.
    """
    s = solved(*which)
    robot, loads, layout = s.task.robot, s.knots.loads, s.planner.layout
    rows = rows_by_constraint(
        s, np.array(function(s.planner, "nlp_g")(s.w, parameters(s.planner.layout, s.task))).ravel()
    )
    columns = robot.leg_joint_index

    def of_joints(legs):
        joints = np.empty(len(robot.joint_names))
        joints[columns] = legs[: columns.size].reshape(columns.shape)
        return joints

    torque, speed, edges = [], {}, []
    legs, joints = columns.shape
    for k in range(1, layout.knots - 1):
        role = layout.roles[k]
        here = shares(rows[k]["joint_torque"]).reshape(-1, joints)
        mean = here[:legs].copy()
        for leg in role.swinging:
            if leg in role.touching_down:
                after = here[legs + role.touching_down.index(leg)]
            else:
                after = shares(rows[k + 1]["joint_torque"]).reshape(-1, joints)[leg]
            mean[leg] = (mean[leg] + after) / 2
        torque.append(of_joints(mean.ravel()))
        if "joint_speed" in rows[k]:
            found = shares(rows[k]["joint_speed"])
            speed[k] = of_joints(found)
            if role.at_edge:
                mine = columns[list(role.at_edge)].ravel()
                true = loads.edge_velocity[k, mine] / robot.speed_limit[mine]
                edges.append((found[columns.size :], true))
    needed = loads.joint_torque / robot.torque_limit, loads.joint_velocity / robot.speed_limit
    return np.array(torque), speed, needed[0][1:], needed[1], edges


@every_plan
def test_torques_are_those_of_the_whole_body(which):
    """What the rows leave out (moving legs seen from the base, their changing inertia) is small."""
    rows, _, loads, *_ = rows_and_loads(which)
    error = np.sqrt(np.mean((rows - loads) ** 2, axis=0))
    assert error.max() < 0.06
    # The torques themselves are not: they reach the limit's neighbourhood.
    assert np.abs(loads).max() > 0.3


@every_plan
def test_speeds_are_those_of_the_postures(which):
    _, rows, _, loads, edges = rows_and_loads(which)
    error = np.array([found - loads[k] for k, found in rows.items()])
    # Fitted legs' rates are slopes of polynomials.
    assert np.sqrt(np.mean(error**2)) < (0.03 if which == BOX else 0.02)
    assert np.abs(loads[list(rows)]).max() > 0.2
    # At lift-off and touchdown the rows have the mean angular velocity of the interval beside it.
    rows, loads = np.hstack(edges)
    assert np.sqrt(np.mean((rows - loads) ** 2)) < 0.04
    assert np.abs(loads).max() > 0.3


@pytest.mark.parametrize("constraint", DRIVES, ids=lambda c: c.name)
def test_shifted_bounds_are_where_the_whole_body_keeps_to_its_drives(constraint):
    """Rows at such a bound, with as much between them and the whole body as here."""
    s = solved("llsrbm-plus", "all")
    bounds = constraint.agreed_bounds(s.knots)
    torque, speed, true_torque, true_speed, _ = rows_and_loads(("llsrbm-plus", "all", "anymal"))
    tops = constraint.tops(s.task)
    assert (bounds.upper <= tops[:, None]).all()
    assert (bounds.lower >= -tops[:, None]).all()
    if constraint.name == "joint_torque":
        upper, lower = (x[1:-1, MIDDLE] for x in (bounds.upper, bounds.lower))
        edge, gap = 0.85 + 0.10, true_torque - torque
    elif constraint.name == "joint_speed":
        knots = list(speed)
        upper, lower = bounds.upper[knots, MIDDLE], bounds.lower[knots, MIDDLE]
        edge, gap = tops[MIDDLE] + 0.03, true_speed[knots] - np.array(list(speed.values()))
    else:
        return
    # Rows as intervals begin meet the larger of two gaps: their mean meets each.
    assert (upper + gap).max() < edge - RESERVE + 1e-9
    assert (lower + gap).min() > -edge + RESERVE - 1e-9
    again = constraint.agreed_bounds(
        s.knots.under(replace(s.task, agreed_bounds={constraint.name: bounds}))
    )
    np.testing.assert_array_equal(again.reserve, 0.0)  # nothing is exceeded


def test_a_bound_that_did_not_do_is_tightened():
    s = solved("srbm", "twist")
    weak = s.task.limits.model_copy(update={"torque_share": 0.2})
    task = replace(s.task, limits=weak)
    constraint = DRIVES[0]
    first = constraint.agreed_bounds(s.knots.under(task))
    second = constraint.agreed_bounds(
        s.knots.under(replace(task, agreed_bounds={constraint.name: first}))
    )
    exceeded = constraint.excess(s.knots.under(task)) > 0
    assert exceeded.any()
    assert (second.reserve[:-1][exceeded] > 0).all()
    assert (second.upper <= first.upper + 1e-12).all()
