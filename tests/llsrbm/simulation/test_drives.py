"""Torques in the world: their joints, delay and limits."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from llsrbm.control.motor_command import MotorCommand
from llsrbm.motion.rollout import Disturbance
from llsrbm.simulation.world import FLAT, STEP, Drives, World, steps_in
from tests.llsrbm.simulation.anymal_world import ANYMAL, JOINTS, TICK, in_the_air, world_of


def test_torques_are_late_by_the_delay():
    commands = np.random.default_rng(2).normal(size=(20, JOINTS))
    late, prompt = world_of(torque_delay_ticks=1), world_of()
    late.reset(*in_the_air())
    applied = np.array([late.advance(command).torque for command in commands])
    assert applied[1:] == pytest.approx(commands[:-1], abs=1e-12)
    prompt.reset(*in_the_air())
    states = []
    for command in [commands[0], *commands[:-1]]:
        prompt.advance(command)
        states.append(prompt.state()[0])
    assert late.state()[0] == pytest.approx(states[-1], abs=1e-12)


def test_torques_act_on_the_joints_of_their_names():
    for j in range(JOINTS):
        world = world_of()
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
    applied, limit = Drives(ANYMAL, 0).limited(torque, speed)
    left = most * np.clip((fastest - np.abs(speed)) / (0.3 * fastest), 0, 1)
    expected = np.where(torque * speed > 0, left, most)
    assert limit[torque != 0] == pytest.approx(expected[torque != 0], abs=1e-9)
    clipped = np.sign(torque) * np.minimum(np.abs(torque), expected)
    assert applied == pytest.approx(clipped, abs=1e-9)


def test_less_voltage_takes_speed_and_no_torque():
    drives, full = Drives(ANYMAL, 0), Drives(ANYMAL, 0)
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
    following, told = world_of(), World(ANYMAL, FLAT, Disturbance(), STEP)
    following.reset(*in_the_air())
    told.reset(*in_the_air())
    for _ in range(10):
        result = following.advance(law)
        torques = []
        for _ in range(steps_in(TICK)):
            q, v = told.state()
            torques.append(told.advance(law.torque(q[7:], v[6:])).torque)
        assert result.torque == pytest.approx(np.mean(torques, axis=0), rel=1e-9)
    for one, other in zip(following.state(), told.state(), strict=True):
        assert one == pytest.approx(other, abs=1e-9)


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
