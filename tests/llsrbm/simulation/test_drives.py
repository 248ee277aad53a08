"""Torques in the world: their joints, delay and limits."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from llsrbm.control.motor_command import MotorCommand
from llsrbm.motion.rollout import Disturbance
from llsrbm.robots import load_robot
from llsrbm.simulation.world import FLAT, STEP, Drives, World, steps_in
from tests.llsrbm.kinematics import links_alone
from tests.llsrbm.simulation.anymal_world import ANYMAL, JOINTS, TICK, in_the_air, world_of


def step_by_step(**disturbance):
    """A world whose ticks are single steps, with commands that act at once."""
    world = World(ANYMAL, FLAT, Disturbance(**disturbance), STEP, 0.0)
    world.reset(*in_the_air())
    return world


@pytest.mark.parametrize("ticks", [0, 1])
@pytest.mark.parametrize("delay", [0.0, 0.001, 0.0025, None])
def test_torques_are_late_by_the_delay_of_drives_and_disturbance(delay, ticks):
    """As in steps of its own, each told the torque that acts in it; the first one before all."""
    commands = np.random.default_rng(2).normal(scale=5, size=(20, JOINTS))
    late, prompt = world_of(delay=delay, torque_delay_ticks=ticks), step_by_step()
    late.reset(*in_the_air())
    steps, own = steps_in(TICK), ANYMAL.drive_delay if delay is None else delay
    behind = round(own / STEP) + ticks * steps
    for tick, command in enumerate(commands):
        result = late.advance(command)
        told = [commands[max(0, (tick * steps + k - behind) // steps)] for k in range(steps)]
        for torque in told:
            prompt.advance(torque)
        assert result.torque == pytest.approx(np.mean(told, axis=0), abs=1e-12)
    for one, other in zip(late.state(), prompt.state(), strict=True):
        assert one == pytest.approx(other, abs=1e-9)


def test_torques_act_on_the_joints_of_their_names():
    for j in range(JOINTS):
        world = world_of(delay=0.0, joint_friction_factor=0.0)
        world.reset(*in_the_air())
        torque = np.zeros(JOINTS)
        torque[j] = 1.0
        world.advance(torque)
        data = ANYMAL.model.createData()
        q, v = in_the_air()
        a = pin.aba(ANYMAL.model, data, q, v, np.concatenate([np.zeros(6), torque]))
        assert world.state()[1][6:] == pytest.approx(TICK * a[6:], abs=0.02 * TICK * abs(a).max())


@given(
    arrays(float, JOINTS, elements=st.floats(-120, 120)),
    arrays(float, JOINTS, elements=st.floats(-30, 30)),
)
def test_torques_are_limited_by_the_speed_that_they_drive(torque, speed):
    most, fastest = ANYMAL.file.limits.torque, ANYMAL.file.limits.joint_speed
    applied, limit = Drives(ANYMAL).limited(torque, speed)
    left = most * np.clip((fastest - np.abs(speed)) / (0.3 * fastest), 0, 1)
    expected = np.where(torque * speed > 0, left, most)
    assert limit[torque != 0] == pytest.approx(expected[torque != 0], abs=1e-9)
    clipped = np.sign(torque) * np.minimum(np.abs(torque), expected)
    assert applied == pytest.approx(clipped, abs=1e-9)


def test_less_voltage_takes_speed_and_no_torque():
    drives, full = Drives(ANYMAL), Drives(ANYMAL)
    drives.voltage = 0.8
    torque, speed = np.full(JOINTS, 1e3), np.linspace(0, 14, JOINTS)
    np.testing.assert_allclose(
        drives.limited(torque, 0.8 * speed)[0], full.limited(torque, speed)[0], rtol=1e-12
    )
    assert (drives.limited(torque, 0 * speed)[0] == ANYMAL.file.limits.torque).all()


def test_a_law_is_followed_in_every_step():
    """As torques of the same law are that a controller of as many ticks sends."""
    rng = np.random.default_rng(4)
    target, speed, tau = rng.normal(scale=0.2, size=(3, JOINTS))
    law = MotorCommand(
        in_the_air()[0][7:] + target, speed, tau, np.full(JOINTS, 90.0), np.full(JOINTS, 2.0)
    )
    following, told = world_of(delay=0.0), step_by_step()
    following.reset(*in_the_air())
    for _ in range(10):
        result = following.advance(law)
        torques = []
        for _ in range(steps_in(TICK)):
            q, v = told.state()
            torques.append(told.advance(law.torque(q[7:], v[6:])).torque)
        assert result.torque == pytest.approx(np.mean(torques, axis=0), rel=1e-9)
    for one, other in zip(following.state(), told.state(), strict=True):
        assert one == pytest.approx(other, abs=1e-9)


def test_drives_that_are_reset_forget_what_was_sent():
    drives = Drives(ANYMAL, late=3, steps=5)
    for k in range(3):
        drives.send(np.full(JOINTS, float(k)))
    assert [drives.acting(step)[0] for step in range(5)] == [1, 1, 1, 2, 2]
    drives.reset()
    drives.send(np.full(JOINTS, 7.0))
    assert [drives.acting(step)[0] for step in range(5)] == [7] * 5


def swung(robot, seconds=0.3):
    """q, v at steps' edges, torques of steps: joints swing about their posture, the robot falls.

    So little that no links meet.
    """
    rng, joints = np.random.default_rng(3), len(robot.joint_names)
    world = World(robot, FLAT, Disturbance(), STEP)
    q = robot.posture.copy()
    q[2] += 5.0
    world.reset(q, np.zeros(robot.model.nv))
    size, period = rng.choice([-0.2, 0.2], joints), rng.uniform(0.08, 0.12, joints)
    states, torques = [world.state()], []
    for time in np.arange(0.0, seconds, STEP):
        swing = size * np.cos(2 * np.pi * time / period) - states[-1][1][6:] / robot.speed_limit
        result = world.advance(robot.torque_limit * swing)
        assert not result.touches
        torques.append(result.torque)
        states.append(world.state())
    return *(np.array(values) for values in zip(*states, strict=True)), np.array(torques)


def accelerations(q, v):
    """(K, nv) by which velocities change from one step to the next, as Pinocchio has them."""
    rate = np.diff(v, axis=0) / STEP
    for k, change in enumerate(rate):
        # The base's velocity is in its own axes, which turn.
        now, then = (pin.Quaternion(q[i, 3:7]).toRotationMatrix() for i in (k, k + 1))
        change[:3] = (now.T @ then @ v[k + 1, :3] - v[k, :3]) / STEP
        change[:3] -= np.cross(v[k, 3:6], v[k, :3])
    return rate


@pytest.mark.parametrize("name", ["go2", "slider"])
def test_what_torques_move_beside_links_is_rotors(name):
    """Recorded torque less Pinocchio's of links alone less friction: armature by acceleration."""
    robot = load_robot(name)
    model = links_alone(robot)
    data, (q, v, torque) = model.createData(), swung(robot)
    rate, before, after = accelerations(q, v), v[:-1, 6:], v[1:, 6:]
    links = [pin.rnea(model, data, *state)[6:] for state in zip(q, v, rate)]
    # MuJoCo takes the damping of the speed with which a step ends.
    rest = torque - links - robot.friction * np.sign(before) - robot.damping * after
    moving = np.minimum(np.abs(before), after * np.sign(before)) > 0.03 * robot.speed_limit
    assert (moving.sum(axis=0) > 20).all()
    rate = rate[:, 6:]
    slope = (rest * rate * moving).sum(axis=0) / (rate**2 * moving).sum(axis=0)
    np.testing.assert_allclose(slope, robot.armature, rtol=0.001)


def test_friction_never_pushes_a_joint_on():
    """Not even one that its drive brakes hard: it stops earlier, by the work of friction."""
    direction = -1
    stopped = []
    for factor in (0.0, 1.0):
        world = World(ANYMAL, FLAT, Disturbance(joint_friction_factor=factor), STEP, 0.0)
        q, v = in_the_air()
        v[6:] = direction * 3.0
        world.reset(q, v)
        speeds = []
        while (direction * world.state()[1][6:] > 0.2).all():
            world.advance(np.full(JOINTS, -direction * 20.0))
            speeds.append(direction * world.state()[1][6:])
        stopped.append(np.array(speeds))
    free, held = (speeds[: min(map(len, stopped))] for speeds in stopped)
    assert (np.diff(free - held, axis=0)[:, 2::3] > 0).all()


def test_a_joint_is_not_driven_beyond_its_speed():
    """Each step counts the speed that it meets, not the tick's first."""
    world = world_of()
    world.reset(*in_the_air())
    push = np.zeros(JOINTS)
    push[2] = 100.0
    limits = ANYMAL.file.limits
    last = None
    for _ in range(8):
        speed = abs(world.state()[1][8])
        result = world.advance(push)
        after = abs(world.state()[1][8])
        assert result.torque[2] == pytest.approx(result.torque_limit[2])
        room = [
            min(1, max(0, (limits.joint_speed - w) / (0.3 * limits.joint_speed)))
            for w in (speed, after)
        ]
        assert limits.torque * room[1] - 1e-9 <= result.torque[2] <= limits.torque * room[0] + 1e-9
        last = after
    assert last < 1.02 * limits.joint_speed
