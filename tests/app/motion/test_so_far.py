"""Frames out of bare states agree with those of the finished rollout."""

from time import thread_time

import numpy as np
import pytest

from app.motion.baked import frames_so_far
from llsrbm.look.shown_motion import shown_motion
from llsrbm.motion.whole_body import motion_of_states
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot, names
from tests.app.planners import standing_motion
from tests.app.synthetic_plan import FLY, STAND, synthetic_plan

DRAWN = ("com", "body_position", "body_wxyz", "inertia_axes", "yaw_wxyz", "foot_position")


def jumping(robot, instants=121):
    """Instants and states of a jump: a plan's, with joints that move."""
    plan = synthetic_plan(Jump(robot=robot, twist=1.5, forward=0.3))
    time = np.linspace(0.0, plan.time[-1], instants)
    base = np.array([np.interp(time, plan.time, column) for column in plan.base_position.T]).T
    quat = np.array([np.interp(time, plan.time, column) for column in plan.base_quat.T]).T
    quat /= np.linalg.norm(quat, axis=1, keepdims=True)
    joints = plan.joint_position[0] + 0.1 * np.sin(time)[:, None]
    return time, np.hstack([base, quat, joints])


@pytest.mark.parametrize("name", names())
def test_frames_are_those_of_the_same_motion_with_velocities(name):
    robot, (time, qpos) = load_robot(name), jumping(name)
    frames = frames_so_far(robot, time, qpos)
    full = shown_motion(
        motion_of_states(robot, "unitree-csv", time, qpos, np.zeros((len(time), robot.model.nv)))
    )
    for field in DRAWN:
        np.testing.assert_allclose(getattr(frames, field), getattr(full, field), atol=1e-9)
    assert np.array_equal(frames.time, time)
    assert not frames.foot_force.any()


def test_flight_is_told_from_the_feet():
    robot = load_robot("anymal")
    plan = synthetic_plan(Jump(twist=1.5))
    qpos = np.hstack([plan.base_position, plan.base_quat, plan.joint_position])
    frames = frames_so_far(robot, plan.time, qpos)
    inner = (plan.time > STAND + 0.05) & (plan.time < STAND + FLY - 0.05)
    outer = (plan.time < STAND - 0.05) | (plan.time > STAND + FLY + 0.05)
    flies = ~frames.stands.any(axis=1)
    assert flies[inner].all()
    assert not flies[outer].any()


@pytest.mark.parametrize("instants", [1, 2, 7])
def test_a_simulation_that_has_just_begun_has_frames(instants):
    frames = frames_so_far(load_robot("anymal"), *standing_motion("anymal", instants))
    assert frames.com.shape == (instants, 3)
    assert np.isfinite(frames.inertia_axes).all()


def test_five_times_a_second_is_cheap():
    """Three seconds of motion; 0.2 s of wall time would be all there is."""
    robot, (time, qpos) = load_robot("anymal"), jumping("anymal", 181)
    took = []
    for _ in range(3):
        began = thread_time()
        frames_so_far(robot, time, qpos)
        took.append(thread_time() - began)
    assert min(took) < 0.03
