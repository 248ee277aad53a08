from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from app.motion.baked import FRAME_RATE, bake_plan, bake_rollout, presentable
from llsrbm.look.timeline import force_phases
from llsrbm.motion.rollout import Mode
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.app.synthetic_plan import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout


@pytest.fixture(scope="module")
def robot():
    return load_robot("anymal")


@pytest.fixture(scope="module")
def rollout():
    """Every joint at an angle of its own, so that none can be taken for another."""
    made = synthetic_rollout(synthetic_plan(Jump(twist=1.5, forward=0.3)))
    qpos = made.qpos.copy()
    qpos[:, 7:] += 0.1 * np.arange(qpos.shape[1] - 7)
    return replace(made, qpos=qpos)


@pytest.fixture(scope="module")
def replay(rollout):
    return bake_rollout(rollout)


def test_bodies_are_where_pinocchio_puts_them(robot, rollout, replay):
    assert rollout.joint_names != robot.joint_names
    data = robot.model.createData()
    for frame in (0, len(replay.frames.time) // 2, -1):
        tick = int(np.argmin(np.abs(rollout.time - replay.frames.time[frame])))
        angle = dict(zip(rollout.joint_names, rollout.qpos[tick, 7:], strict=True))
        q = np.concatenate(
            [
                rollout.base_position[tick],
                np.roll(rollout.base_quat[tick], -1),
                [angle[name] for name in robot.joint_names],
            ]
        )
        pin.forwardKinematics(robot.model, data, q)
        for body in range(robot.model.njoints - 1):
            expected = data.oMi[body + 1]
            wxyz = replay.frames.body_wxyz[frame, body]
            R = Rotation.from_quat(wxyz, scalar_first=True).as_matrix()
            assert replay.frames.body_position[frame, body] == pytest.approx(expected.translation)
            assert pytest.approx(expected.rotation, abs=1e-9) == R


def test_frames_are_about_as_many_as_are_shown(rollout, replay):
    steps = np.diff(replay.frames.time)
    assert steps.max() < 1.2 / FRAME_RATE
    assert replay.frames.time[0] == rollout.time[0]
    assert replay.frames.end == rollout.time[-1]


def test_a_frame_shows_the_mean_force_until_the_next_one(rollout, replay):
    """The frames' forces have the impulse of the rollout's."""
    frames = replay.frames
    tick = rollout.time[1]
    lasting = np.diff(np.append(frames.time, rollout.time[-1] + tick))
    impulse = np.einsum("f,flk->lk", lasting, frames.foot_force)
    assert impulse == pytest.approx(rollout.contact_force.sum(axis=0) * tick)


@pytest.mark.parametrize("ticks", [1, 2, 3, 4, 7])
def test_however_short_it_is_drawn(rollout, ticks):
    arrays = ("time", "qpos", "com", "base_position", "base_quat", "inertia", "foot_position")
    arrays += ("phase", "contact_force")
    short = replace(rollout, **{name: getattr(rollout, name)[:ticks] for name in arrays})
    frames = bake_rollout(short).frames
    assert frames.time[0] == rollout.time[0]
    assert frames.end == rollout.time[ticks - 1]


@pytest.mark.parametrize(
    ("mode", "expected"),
    [
        ([0, 0, 1, 1, 0], [(2, 4)]),
        ([1, 0, 0, 1, 1], [(0, 1), (3, 4)]),
        ([0, 0, 0, 0, 0], []),
    ],
)
def test_force_phases(rollout, mode, expected):
    part = replace(rollout, time=np.arange(5.0), mode=np.array(mode) * int(Mode.FORCE))
    assert force_phases(part) == expected


def test_a_stiff_robot_has_equal_ellipsoids(robot):
    """But for how feet that stand still move seen from a body that begins to turn."""
    replay = bake_plan(synthetic_plan(Jump(twist=1.5, forward=0.3, height=0.1)), robot)
    assert replay.frames.inertia_axes == pytest.approx(
        np.broadcast_to(replay.rigid_axes, replay.frames.inertia_axes.shape), rel=0.01
    )
    same = np.abs(np.sum(replay.frames.inertia_wxyz * replay.rigid_wxyz, axis=1))
    assert same == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("broken", ["com", "base_quat", "inertia", "joint_position"])
def test_a_diverged_plan_is_not_drawn(broken):
    plan = synthetic_plan(Jump())
    assert presentable(plan)
    values = getattr(plan, broken).copy()
    values[3] = np.nan
    assert not presentable(replace(plan, **{broken: values}))


def test_a_plan_whose_time_stands_still_is_not_drawn():
    plan = synthetic_plan(Jump())
    time = plan.time.copy()
    time[4] = time[3]
    assert not presentable(replace(plan, time=time))
