"""How a whole body comes down."""

import math

import numpy as np
import pytest

import llsrbm
from llsrbm.certified_plan import CertifiedPlanner
from llsrbm.mechanics import GRAVITY, tilt
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.planning.whole_body.rounds import ASTRAY
from llsrbm.robots import load_robot

FEET = (0, 1, 2, 3)


def test_what_stands_after_a_flight_has_landed():
    hops = Grid(((FEET, 2), ((), 3), (FEET, 2), ((), 3), ((2, 3), 2)))
    landed = hops.landed
    assert hops.last_landing == 4
    assert len(landed) == 2 * hops.intervals + 1
    phases = np.array([hops.phase_at(half) for half in range(len(landed))])
    assert [landed[phases == p].all() for p in range(5)] == [False, False, True, False, True]
    assert [landed[phases == p].any() for p in range(5)] == [False, False, True, False, True]


def planned(robot="go2", **degrees_and_metres):
    degrees_and_metres["twist"] = math.radians(degrees_and_metres["twist"])
    jump = llsrbm.Jump(robot, **degrees_and_metres)
    plan = CertifiedPlanner().from_table(make_task(jump, load_robot(robot)))
    assert plan is not None
    return plan, plan.time >= plan.touchdown - 1e-9


@pytest.mark.parametrize("robot", ["go2", "anymal"])
def test_balls_that_roll_come_to_rest_in_their_places(robot):
    # ANYmal's came to rest 10 mm beside them, Go2's 6 mm.
    plan, _ = planned(robot, twist=80, forward=0.3, lateral=0.05, height=0.05)
    place = make_task(plan.jump, load_robot(robot)).places[-1].feet
    assert np.linalg.norm((plan.foot_position[-1] - place)[:, :2], axis=1).max() < ASTRAY


def test_the_trunk_comes_down_level():
    # Onto a box it leant by 11 degrees, and by 19 once it had landed in the simulator.
    plan, landed = planned(twist=-16, forward=0.41, lateral=-0.08, height=0.21)
    assert np.degrees(tilt(plan.base_quat[landed]).max()) < 6


def test_feet_share_the_weight_and_drives_keep_a_reserve_when_they_land():
    # Two feet carried nothing for 0.2 s, and drives of a jump down were at their limits: both fell.
    plan, landed = planned(twist=99.2, forward=0.115, lateral=0.142, height=-0.082)
    forces = plan.contact_force[landed].reshape(landed.sum(), 4, -1)[:-1, :, 2]
    assert forces.sum(axis=1).min() > 0
    robot = load_robot("go2")
    share = robot.file.reserve.landing_carried / 4 * robot.mass * GRAVITY
    # Between the nodes, where the rows are, forces are lines.
    assert forces.min() > share - 0.01 * robot.mass * GRAVITY
    pushing = plan.contact_force[plan.time < plan.lift_off - 1e-9].reshape(-1, 4, 3)[:, :, 2]
    assert pushing.min() > robot.file.reserve.carried / 4 * robot.mass * GRAVITY - 1e-6
    order = [plan.joint_names.index(name) for name in robot.joint_names]
    share = np.abs(plan.joint_torque[:, order]) / robot.torque_limit
    assert share[landed].max() <= 0.7 * robot.file.limits.torque_share + 2e-3
    assert share[~landed].max() > share[landed].max()
