"""A robot behind its topics in one process, its player in another, on the loopback."""

import random
import time

import numpy as np
import pytest

from llsrbm.control.motor_command import MotorCommand
from llsrbm.errors import InputError
from llsrbm.robots import load_robot
from llsrbm.wire.simulated_robot import TICK

pytest.importorskip("cyclonedds", reason="needs the extra llsrbm[wire]")

from llsrbm.wire.dds import DdsLink, DdsRobot, default_domain
from tests.llsrbm.wire.simulator_process import STARTS, simulator

GO2, G1 = load_robot("go2"), load_robot("g1")


@pytest.fixture
def domain():
    """One of its own, so that tests beside this one do not hear it."""
    return random.randrange(20, 200)


def holding(robot):
    stiff = robot.torque_limit / 0.2
    still = np.zeros(len(stiff))
    return MotorCommand(robot.posture[7:], still, still, stiff, 0.02 * stiff)


def test_a_second_over_the_loopback(domain):
    with simulator(domain) as ended:
        link = DdsLink(GO2, "lo", domain)
        first = link.receive(STARTS)
        assert first is not None
        command, times, sent = holding(GO2), [first.time], 0
        while times[-1] < first.time + 1.0:
            reading = link.receive(STARTS)
            times.append(reading.time)
            link.send(command)
            sent += 1
        assert link.health.charge == 1
        link.close()  # the player has gone; the robot goes on by itself
        time.sleep(1.0)
        result = ended()
    arrived = len(times) / (1 + (times[-1] - times[0]) / TICK)
    assert arrived > 0.99
    assert (np.diff(times) > 0).all()
    assert 0.98 * sent <= result["commands"] <= sent
    assert result["wrong_checksums"] == 0
    assert result["braking"]
    assert result["time_s"] > times[-1] + 0.05
    assert reading.q == pytest.approx(GO2.posture[7:], abs=0.1)
    assert reading.foot_force.sum() == pytest.approx(9.81 * GO2.mass, rel=0.5)


@pytest.mark.parametrize("robot", [GO2, G1], ids=lambda robot: robot.name)
def test_both_ends_in_one_process(robot, domain):
    link, end = DdsLink(robot, "lo", domain), DdsRobot(robot, "lo", domain)
    command = holding(robot)
    for _ in range(100):
        link.send(command)
        (came,) = end.commands(5.0)
        assert came.q == pytest.approx(command.q, rel=1e-6)
    assert end.commands(0.0) == []
    assert end.refused == 0
    assert link.receive(0.01) is None
    link.close()
    end.close()


def test_a_reader_that_is_late_loses_nothing(domain):
    link, end = DdsLink(GO2, "lo", domain), DdsRobot(GO2, "lo", domain)
    for k in range(200):
        still = np.zeros(12)
        link.send(MotorCommand(still + k, still, still, still, still))
    seen = []
    while len(seen) < 200 and (commands := end.commands(5.0)):
        seen += [command.q[0] for command in commands]
    assert seen == list(range(200))


def test_interfaces_and_domains_that_are_not_there():
    with pytest.raises(InputError, match=r'interface: expected one of .*lo.*, got "wire0"'):
        DdsLink(GO2, "wire0")
    with pytest.raises(InputError, match=r"domain: expected 0 to 230, got 500"):
        DdsLink(GO2, "lo", 500)
    assert (default_domain("lo"), default_domain("eth0")) == (1, 0)
