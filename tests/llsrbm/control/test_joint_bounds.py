"""Stops and speeds that the controller keeps by itself: in MuJoCo, whose joints have no stops."""

import numpy as np
import pytest

from llsrbm.control.joint_bounds import SPEED, JointBounds
from llsrbm.control.whole_body import WholeBody
from llsrbm.robots import load_robot
from tests.llsrbm.control.floating import floating


def stops(name):
    model = load_robot(name).model
    return model.lowerPositionLimit[7:], model.upperPositionLimit[7:]


def beyond(name, positions):
    """By how much of their ranges joints are beyond a stop, the farthest."""
    lower, upper = stops(name)
    return (np.maximum(lower - positions, positions - upper) / (upper - lower)).max()


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize(
    ("name", "joint"),
    [("go2", 0), ("go2", 2), ("slider", 2), ("g1", 4)],  # a hip, a knee, a slide, an ankle
)
def test_a_task_beyond_a_stop_ends_before_it(name, joint, side):
    lower, upper = stops(name)
    wanted = load_robot(name).posture[7:].copy()
    of_legs = load_robot(name).leg_joint_index[:, joint]
    # One end of its range, and a fifth more.
    wanted[of_legs] = ((lower + upper) / 2 + side * 0.7 * (upper - lower))[of_legs]
    gains = (1600, 80)  # so stiff that stiction holds no ankle
    assert beyond(name, floating(name, wanted, 0.0, gains=gains)[0]) < 0.0
    assert beyond(name, floating(name, wanted, 0.0, gains=gains, bounded=False)[0]) > 0.05


@pytest.mark.parametrize("name", ["anymal", "slider"])
def test_a_task_too_fast_for_the_drives_is_followed_at_their_speed(name):
    robot = load_robot(name)
    away = np.sign(np.arange(len(robot.joint_names)) % 2 - 0.5)
    _, speeds = floating(name, robot.posture[7:], 100 * away * robot.speed_limit, seconds=0.05)
    assert (np.abs(speeds) / robot.speed_limit).max() < 1.01 * SPEED


@pytest.mark.parametrize("seed", range(2))
def test_bounds_never_exclude_each_other(seed):
    robot = load_robot("slider")
    body, bounds = WholeBody(robot), JointBounds(robot)
    rng = np.random.default_rng(seed)
    v = 30 * rng.standard_normal(robot.model.nv)
    q = robot.posture.copy()
    q[7:] += rng.standard_normal(len(q) - 7)
    body.update(q, v)
    lower, upper = bounds.accelerations(body)
    assert (lower <= upper).all()
