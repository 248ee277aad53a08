"""A robot behind its wire: its motors' law, delays, silence, battery, and repetition."""

import numpy as np
import pinocchio as pin
import pytest

from llsrbm.control.motor_command import MotorCommand
from llsrbm.errors import InputError
from llsrbm.robots import load_robot
from llsrbm.simulation.readings import JOINT_ZERO
from llsrbm.wire.channel import Faults
from llsrbm.wire.motors import SILENCE, standing_torque
from llsrbm.wire.simulated_robot import SAG, TICK, Conditions, DirectLink, SimulatedRobot

GO2 = load_robot("go2")
JOINTS = len(GO2.joint_names)
NO_DELAY = Conditions(delay=0.0, delay_spread=0.0)


def in_the_air(conditions=NO_DELAY, seed=0):
    q = GO2.posture.copy()
    q[2] += 5.0
    return SimulatedRobot(GO2, conditions, seed, posture=q)


def holding(kp=80.0, kd=3.0):
    still = np.zeros(JOINTS)
    return MotorCommand(GO2.posture[7:], still, still, still + kp, still + kd)


@pytest.mark.parametrize("name", ["go2", "slider", "g1"])
def test_it_stands_still_until_commands_arrive(name):
    robot = load_robot(name)
    simulated = SimulatedRobot(robot, seed=3)
    simulated.advance(1.0)
    q, v = simulated.world.state()
    assert np.abs(q[7:] - robot.posture[7:]).max() < 4 * JOINT_ZERO
    assert abs(q[2] - robot.posture[2]) < 5e-3
    assert np.abs(v).max() < 0.01
    assert not simulated.braking
    assert simulated.heard == 0


def test_a_hung_robot_stays_where_it_is_whatever_its_legs_do():
    simulated, still = SimulatedRobot(GO2, NO_DELAY, hung=True), np.zeros(JOINTS)
    base = simulated.world.state()[0][:7]
    for k in range(200):
        swing = GO2.posture[7:] + 0.3 * np.sin(0.05 * k)
        simulated.send(MotorCommand(swing, still, still, still + 60.0, still + 3.0))
        assert not simulated.tick().contact.any()
    q, v = simulated.world.state()
    assert np.abs(q[7:] - GO2.posture[7:]).max() > 0.05
    assert q[:7] == pytest.approx(base, abs=1e-5)
    assert np.abs(v[:6]).max() < 1e-4


def test_standing_torques_leave_the_ground_to_carry_the_weight():
    """Against Pinocchio: no joint accelerates if the feet push as the torques demand."""
    torque = standing_torque(GO2, GO2.posture)
    model, data = GO2.model, GO2.model.createData()
    pin.framesForwardKinematics(model, data, GO2.posture)
    pin.computeJointJacobians(model, data, GO2.posture)
    gravity = pin.computeGeneralizedGravity(model, data, GO2.posture)
    below = np.array([0.0, 0.0, GO2.foot_lift])
    rows = []
    for leg in GO2.legs:
        J = pin.getFrameJacobian(
            model, data, leg.foot_frame_id, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        rows.append(J[:3] + pin.skew(below) @ J[3:])
    wrench = np.vstack(rows).T
    needed = gravity - np.concatenate([np.zeros(6), torque])
    force = np.linalg.lstsq(wrench, needed, rcond=None)[0]
    assert wrench @ force == pytest.approx(needed, abs=1e-6)
    assert force[2::3].sum() == pytest.approx(9.81 * GO2.mass, rel=1e-6)
    assert (force[2::3] > 0).all()


def test_motors_follow_the_law_in_every_step():
    """Joints released from a step in position swing as an oscillator of the law would have it."""
    simulated = in_the_air()
    target = GO2.posture[7:].copy()
    target[1] += 0.05
    kp, kd = np.full(JOINTS, 40.0), np.full(JOINTS, 1.0)
    dq, tau = np.linspace(-0.2, 0.2, JOINTS), np.linspace(-1, 1, JOINTS)
    link = DirectLink(simulated)
    zero = link.receive(1.0).q - simulated.world.state()[0][7:]  # motors see it, too
    assert 0 < np.abs(zero).max() < 4 * JOINT_ZERO
    for _ in range(20):
        command = MotorCommand(target, dq, tau, kp, kd)
        link.send(command)
        q, v = simulated.world.state()
        result = simulated.tick()
        after_q, after_v = simulated.world.state()
        first = tau + kp * (target - zero - q[7:]) + kd * (dq - v[6:])
        last = tau + kp * (target - zero - after_q[7:]) + kd * (dq - after_v[6:])
        # The mean of four steps lies between what the tick's first and last state give, nearly: the
        # torque held over the tick would be `first`.
        low, high = np.minimum(first, last) - 0.02, np.maximum(first, last) + 0.02
        assert (low < result.torque).all()
        assert (result.torque < high).all()
    assert simulated.heard == 20


def test_a_command_takes_its_time():
    simulated = in_the_air(Conditions(delay=0.003, delay_spread=0.0))
    before, torque = np.full(JOINTS, 0.5), np.linspace(-2, 2, JOINTS)
    simulated.send(MotorCommand.of_torque(before))
    simulated.advance(2 * TICK)
    simulated.send(MotorCommand.of_torque(torque))
    assert simulated.tick().torque == pytest.approx(before)
    half = simulated.tick().torque  # it arrives in the middle of this tick
    assert half == pytest.approx((before + torque) / 2)
    assert simulated.tick().torque == pytest.approx(torque, abs=1e-12)


def test_motors_brake_after_silence_and_follow_again():
    simulated = SimulatedRobot(GO2, NO_DELAY)
    simulated.send(holding())
    ticks = 0
    while not simulated.braking:
        simulated.tick()
        ticks += 1
    assert ticks * TICK == pytest.approx(SILENCE, abs=1.5 * TICK)
    simulated.advance(0.1)
    speed, result = simulated.world.state()[1][6:], simulated.tick()
    moving = np.abs(speed) > 0.1
    assert moving.any()
    assert (np.sign(result.torque[moving]) == -np.sign(speed[moving])).all()
    simulated.advance(2.0)
    q, v = simulated.world.state()
    assert np.abs(v).max() < 0.5  # it has sunk, slowly
    assert q[2] < 0.7 * GO2.posture[2]
    simulated.send(holding())
    simulated.advance(2 * TICK)
    assert not simulated.braking


def test_it_repeats_itself_by_the_seed():
    def run(seed):
        conditions = Conditions(faults=Faults(lost=0.1, late=0.01))
        simulated = SimulatedRobot(GO2, conditions, seed)
        link, seen = DirectLink(simulated), []
        for k in range(150):
            reading = link.receive(0.1)
            seen.append([reading.time, *reading.q, *reading.gyro, *reading.torque])
            wave = MotorCommand(
                GO2.posture[7:] + 0.05 * np.sin(0.2 * k), *np.zeros((2, JOINTS)), *holding_gains()
            )
            link.send(wave)
        return np.array(seen), np.concatenate(simulated.world.state())

    first, again, other = run(7), run(7), run(8)
    for one, same in zip(first, again, strict=True):
        np.testing.assert_array_equal(one, same)
    assert (first[1] != other[1]).any()


def holding_gains():
    return np.full(JOINTS, 60.0), np.full(JOINTS, 3.0)


def test_readings_come_each_tick_in_lock_step():
    simulated = SimulatedRobot(GO2, foot_force=True)
    link = DirectLink(simulated)
    times = [link.receive(1.0).time for _ in range(50)]
    assert times == pytest.approx(TICK * np.arange(50))
    reading = link.receive(1.0)
    q, _ = simulated.world.state()
    assert reading.q == pytest.approx(q[7:], abs=0.02)
    assert reading.acceleration[2] == pytest.approx(9.81, abs=0.5)
    assert reading.foot_force.sum() == pytest.approx(9.81 * GO2.mass, rel=0.4)
    assert DirectLink(SimulatedRobot(GO2)).receive(1.0).foot_force is None


def test_a_lost_topic_is_silence():
    simulated = SimulatedRobot(GO2, Conditions(faults=Faults(lost=1.0)))
    link = DirectLink(simulated)
    assert link.receive(0.05) is None
    assert simulated.time == pytest.approx(0.05)


def test_the_battery_sags_with_power_and_takes_speed():
    """A thigh driven hard in the air: less voltage, and the torque ends at a lower speed."""
    fastest = []
    for battery in (True, False):
        simulated = in_the_air(Conditions(delay=0.0, delay_spread=0.0, battery=battery))
        torque = np.zeros(JOINTS)
        torque[[1, 4, 7, 10]] = [20.0, 20.0, 20.0, 20.0]
        simulated.send(MotorCommand.of_torque(torque))
        lowest, speed = 1.0, 0.0
        for _ in range(20):
            result = simulated.tick()
            v = simulated.world.state()[1]
            power = np.maximum(result.torque * v[6:], 0).sum()
            expected = 1 - SAG * power / GO2.mass if battery else 1.0
            assert simulated.voltage == pytest.approx(expected)
            lowest, speed = min(lowest, simulated.voltage), max(speed, np.abs(v[6:]).max())
        assert (lowest < 0.95) == battery
        fastest.append(speed)
    assert fastest[0] < fastest[1]


def test_observers_see_the_truth_of_each_tick():
    simulated, seen = SimulatedRobot(GO2), []
    simulated.observers.append(seen.append)
    before = simulated.world.state()
    simulated.advance(5 * TICK)
    assert [tick.time for tick in seen] == pytest.approx(TICK * np.arange(5))
    np.testing.assert_array_equal(seen[0].state[0], before[0])
    assert seen[-1].result.contact.all()
    weight = seen[-1].result.contact_force.sum(axis=0)
    assert weight == pytest.approx([0, 0, 9.81 * GO2.mass], abs=20)


def test_conditions_out_of_range():
    with pytest.raises(InputError, match=r"delay: expected 0 to 1 s, got -0.001"):
        Conditions(delay=-0.001)
