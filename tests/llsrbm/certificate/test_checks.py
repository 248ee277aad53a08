"""Motions made by hand that fail by one check alone just beyond its limit, and pass just within."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from llsrbm.certificate import certify
from llsrbm.certificate.certificate import certify_stretches
from llsrbm.certificate.sampled_motion import SampledMotion
from llsrbm.motion.whole_body import motion_of_states, velocities
from llsrbm.robots import load_robot
from llsrbm.robots.link_shapes import LinkShapes

ROBOT = load_robot("go2")
COUNT = 30
TIME = np.linspace(0.0, 0.2, COUNT)
CALF, THIGH = (ROBOT.joint_names.index(f"FL_{part}_joint") for part in ("calf", "thigh"))


def broken(motion):
    """Names of the checks that do not hold."""
    return {found.name for found in certify_stretches([motion]) if not found.holds}


@pytest.fixture
def standing():
    """At rest on four feet that carry the weight without a moment."""
    q = ROBOT.posture
    qpos = np.concatenate([q[:3], q[[6, 3, 4, 5]], q[7:]])
    source = motion_of_states(
        ROBOT, "hand", TIME, np.tile(qpos, (COUNT, 1)), np.zeros((COUNT, len(q) - 1))
    )
    arms = ROBOT.feet - ROBOT.com
    rows = np.vstack([np.ones(4), arms[:, 1], -arms[:, 0]])
    up = np.linalg.lstsq(rows, np.array([ROBOT.mass * 9.81, 0.0, 0.0]), rcond=None)[0]
    forces = np.zeros((COUNT, 4, 1, 3))
    forces[:, :, 0, 2] = up
    return SampledMotion(
        source=source,
        robot=ROBOT,
        model=ROBOT.model,
        time=TIME,
        q=np.tile(q, (COUNT, 1)),
        v=np.zeros((COUNT, len(q) - 1)),
        a=np.zeros((COUNT, len(q) - 1)),
        contact=np.ones((COUNT, 4), dtype=bool),
        points=np.tile(ROBOT.feet[:, None], (COUNT, 1, 1, 1)),
        forces=forces,
        recorded_torque=None,
        friction=0.5,
        whole_feet=False,
    )


@pytest.fixture
def falling(standing):
    """Half a metre up, joints at rest, without a contact: it falls, and no drive does anything."""
    q, a = standing.q.copy(), standing.a.copy()
    q[:, 2] += 0.5
    a[:, 2] = -9.81
    nobody, nothing = np.zeros_like(standing.contact), np.zeros_like(standing.forces)
    return replace(standing, q=q, a=a, contact=nobody, forces=nothing)


def test_standing_and_falling_hold(standing, falling):
    assert broken(standing) == broken(falling) == set()


@pytest.mark.parametrize(("beyond", "names"), [(0.009, set()), (0.011, {"joint_position"})])
def test_stop(falling, beyond, names):
    low, high = (
        limit[7 + CALF]
        for limit in (ROBOT.model.lowerPositionLimit, ROBOT.model.upperPositionLimit)
    )
    falling.q[7, 7 + CALF] = high + beyond * (high - low)
    assert broken(falling) == names
    found = certify_stretches([falling])["joint_position"]
    assert (found.where, found.time_s) == ("FL_calf_joint", TIME[7])
    assert found.limit == high
    assert found.worst == pytest.approx(1 + beyond)


def balanced(motion):
    """The motion whose base accelerates as it must with these joints."""
    model, data = motion.model, motion.model.createData()
    a = motion.a.copy()
    for k in range(COUNT):
        mass = pin.crba(model, data, motion.q[k])
        mass = np.triu(mass) + np.triu(mass, 1).T
        bias = pin.nonLinearEffects(model, data, motion.q[k], motion.v[k])
        a[k, :6] = np.linalg.solve(mass[:6, :6], -bias[:6] - mass[:6, 6:] @ a[k, 6:])
    return replace(motion, a=a)


@pytest.mark.parametrize(("share", "names"), [(1.009, set()), (1.011, {"joint_speed"})])
def test_speed(falling, share, names):
    falling.v[3, 6 + CALF] = -share * 15.7
    motion = replace(balanced(falling), recorded_torque=np.zeros((COUNT, 12)))
    assert broken(motion) == names


@pytest.mark.parametrize(("leap", "names"), [(1.009, set()), (1.011, {"joint_speed"})])
def test_speed_of_a_leap_from_one_frame_to_the_next(standing, leap, names):
    """Velocities by differences of the frames around have half of it; those of a file may be 0."""
    qpos, step = standing.source.qpos.copy(), TIME[1]
    qpos[12:, 7 + CALF] += leap * 15.7 * step
    for qvel in (velocities(TIME, qpos), standing.source.qvel):
        found = certify(motion_of_states(ROBOT, "hand", TIME, qpos, qvel))
        assert {each.name for each in found if each.holds is False} & {"joint_speed"} == names
        assert found["joint_speed"].worst == pytest.approx(leap)
        assert TIME[11] < found["joint_speed"].time_s < TIME[12]


def test_how_long_a_joint_is_too_fast(falling):
    falling.v[3:6, 6 + CALF] = 2 * 15.7
    motion = replace(balanced(falling), recorded_torque=np.zeros((COUNT, 12)))
    found = certify_stretches([motion])["joint_speed"]
    assert found.beyond_s == pytest.approx(falling.time[6] - falling.time[3])
    assert found.when.endswith(f", {1e3 * found.beyond_s:.0f} ms beyond")


@pytest.mark.parametrize(
    ("share", "names"), [(1.009, set()), (1.011, {"joint_torque", "torque_at_speed"})]
)
def test_torque(falling, share, names):
    torque = np.zeros((COUNT, 12))
    torque[5, THIGH] = share * 23.7
    assert broken(replace(falling, recorded_torque=torque)) == names


@pytest.mark.parametrize(
    ("share", "names"), [(0.36, set()), (0.37, {"torque_at_speed"}), (-0.99, set())]
)
def test_torque_at_speed(falling, share, names):
    # At nine tenths of the speed a third of the torque is left to drive, and all of it to brake.
    falling.v[3, 6 + THIGH] = 0.9 * 30.1
    torque = np.zeros((COUNT, 12))
    torque[3, THIGH] = share * 23.7
    assert broken(replace(balanced(falling), recorded_torque=torque)) == names


@pytest.mark.parametrize(("share", "names"), [(1.009, set()), (1.011, {"friction"})])
def test_friction(standing, share, names):
    # Two feet, one beside the other, pull apart: neither a force nor a moment on the whole.
    sideways = share * 0.5 * standing.forces[4, :2, 0, 2]
    standing.forces[4, :2, 0, 1] = sideways * [1, -1]
    assert broken(standing) == names


@pytest.mark.parametrize(("share", "names"), [(0.009, set()), (0.011, {"contact_force"})])
def test_contact_force(falling, share, names):
    # A foot in the air is pulled.
    falling.forces[4, 2, 0, 2] = -share * ROBOT.mass * 9.81
    assert broken(falling) == names


@pytest.mark.parametrize(("length", "names"), [(0.009, set()), (0.011, {"slip"})])
def test_slip(standing, length, names):
    standing.q[:, 0] += np.linspace(0, length, COUNT)
    standing.v[:, 0] = length / TIME[-1]
    standing.points[..., 0] += np.linspace(0, length, COUNT)[:, None, None]
    assert broken(standing) - {"dynamics"} == names


@pytest.mark.parametrize(("share", "names"), [(0.09, set()), (0.11, {"dynamics"})])
def test_dynamics(standing, share, names):
    standing.forces[6] *= 1 + share
    assert broken(standing) == names


@pytest.mark.parametrize(("room", "names"), [(0.0052, set()), (0.0048, {"self_distance"})])
def test_self_distance(falling, room, names):
    # A front foot back to the hind leg: halving between apart and through each other.
    shapes, q = LinkShapes.of(ROBOT), falling.q[0].copy()
    apart, through = 0.0, 1.0
    for _ in range(40):
        q[7:10] = falling.q[0, 7:10] + (apart + through) / 2 * np.array([0.0, 1.6, 0.2])
        q[13:16] = falling.q[0, 13:16] + (apart + through) / 2 * np.array([0.0, -1.4, 0.2])
        if shapes.distances(q).min() > room:
            apart = (apart + through) / 2
        else:
            through = (apart + through) / 2
    assert through < 1.0
    falling.q[9] = q
    assert broken(falling) == names


@pytest.mark.parametrize(("depth", "names"), [(0.004, set()), (0.006, {"clearance"})])
def test_clearance(falling, standing, depth, names):
    # Feet that do not stand, that far below the ground that others have stood on.
    falling.q[:, 2] = standing.q[0, 2] - depth
    assert broken(falling) == names


def test_no_number_is_not_within_a_limit(standing):
    standing.forces[3, 1] = np.nan
    assert {"friction", "dynamics"} <= broken(standing)


def foreign(shift, stands):
    """The robot's posture in each frame, shifted by (COUNT, 3) m; `stands`: (COUNT,)."""
    q = ROBOT.posture
    qpos = np.tile(np.concatenate([q[:3], q[[6, 3, 4, 5]], q[7:]]), (COUNT, 1))
    qpos[:, :3] += shift
    found = motion_of_states(ROBOT, "hand", TIME, qpos, velocities(TIME, qpos))
    return replace(found, contact=np.tile(stands[:, None], (1, 4)))


def test_a_foot_that_leaves_between_two_frames_does_not_slip():
    gone = np.arange(COUNT) >= 12
    shift = 0.05 * gone[:, None] * [1.0, 0.0, 1.0]
    assert certify(foreign(shift, ~gone))["slip"].holds
    assert not certify(foreign(shift, gone | ~gone))["slip"].holds


def test_the_ground_is_the_lowest_that_feet_stand_on():
    up = 0.3 * (np.arange(COUNT) >= COUNT // 4)  # on a box most of the time
    always = np.ones(COUNT, dtype=bool)
    assert certify(foreign(up[:, None] * [0.0, 0.0, 1.0], always))["clearance"].holds
    # A single foot in a single frame is not the ground.
    motion = foreign(0.0, always)
    feet = motion.foot_position.copy()
    feet[3, 0, 2] -= 0.3
    lower = certify(replace(motion, foot_position=feet))["clearance"]
    assert lower.worst == pytest.approx(certify(motion)["clearance"].worst)
