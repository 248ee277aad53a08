"""Torques and speeds that the solver bounds, against Pinocchio's of the whole body."""

from functools import cache

import numpy as np
import pytest

from llsrbm.planning.problem.constraints.drives import FAR_BEYOND
from tests.llsrbm.planning.solved import (
    REQUESTS,
    TYPES,
    function,
    parameters,
    rows_by_constraint,
    solved,
)

ANYMALS = [("llsrbm-plus", request, "anymal") for request in (*REQUESTS, *TYPES)]
BOX = ("llsrbm-plus", "box", "slider")
every_plan = pytest.mark.parametrize("which", [*ANYMALS, BOX], ids=lambda w: f"{w[2]}-{w[1]}")


def shares(rows):
    """What the rows say, without what they leave out of large shares."""
    square = rows**4 / FAR_BEYOND**2
    return np.sign(rows) * np.sqrt((square + np.sqrt(square**2 + 4 * rows**4)) / 2)


@cache
def rows_and_loads(which):
    """Shares (N - 1, J) of torque and {knot: (J,)} of speed by the rows; the same by Pinocchio.

    Rows of swinging legs are torques as intervals begin, and as the last one ends; the means of
    both ends belong to the middles, as Pinocchio's. The first interval, at rest, has no rows.
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

    torque, speed = [], {}
    legs, joints = columns.shape
    for k in range(1, layout.knots - 1):
        role = layout.roles[k]
        here = shares(rows[k]["joint_torque"]).reshape(-1, joints)
        mean = here[:legs].copy()
        for leg in role.swinging:
            if leg in role.settling:
                after = here[legs + role.settling.index(leg)]
            else:
                after = shares(rows[k + 1]["joint_torque"]).reshape(-1, joints)[leg]
            mean[leg] = (mean[leg] + after) / 2
        torque.append(of_joints(mean.ravel()))
        if "joint_speed" in rows[k]:
            speed[k] = of_joints(shares(rows[k]["joint_speed"]))
    needed = loads.joint_torque / robot.torque_limit, loads.joint_velocity / robot.speed_limit
    return np.array(torque), speed, needed[0][1:], needed[1]


@every_plan
def test_torques_are_those_of_the_whole_body(which):
    """What the rows leave out (moving legs seen from the base, their changing inertia) is small."""
    rows, _, loads, _ = rows_and_loads(which)
    error = np.sqrt(np.mean((rows - loads) ** 2, axis=0))
    assert error.max() < 0.06
    # The torques themselves are not: they reach the limit's neighbourhood.
    assert np.abs(loads).max() > 0.3


@every_plan
def test_speeds_are_those_of_the_postures(which):
    _, rows, _, loads = rows_and_loads(which)
    error = np.array([found - loads[k] for k, found in rows.items()])
    # Fitted legs' rates are slopes of polynomials.
    assert np.sqrt(np.mean(error**2)) < (0.03 if which == BOX else 0.02)
    assert np.abs(loads[list(rows)]).max() > 0.2
