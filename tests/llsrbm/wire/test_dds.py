"""A robot behind its topics in one process, its player in another, on the loopback."""

import contextlib
import random
import threading
import time

import numpy as np
import pytest

from llsrbm.control.motor_command import MotorCommand
from llsrbm.control.readings import Readings
from llsrbm.errors import Error, InputError
from llsrbm.robots import load_robot
from llsrbm.wire.simulated_robot import TICK

pytest.importorskip("cyclonedds", reason="needs the extra llsrbm[wire]")

from llsrbm.wire import motion_switcher
from llsrbm.wire.dds import DdsLink, DdsRobot, default_domain
from tests.llsrbm.wire import unitree_service as sdk
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


@contextlib.contextmanager
def threads(*loops):
    """Functions that are called every 2 ms, each in a thread of its own, within the block."""
    over = threading.Event()

    def repeat(loop):
        while not over.wait(0.002):
            loop()

    running = [threading.Thread(target=repeat, args=(loop,)) for loop in loops]
    for thread in running:
        thread.start()
    try:
        yield
    finally:
        over.set()
        for thread in running:
            thread.join()


def still(robot):
    zero = np.zeros(len(robot.joint_names))
    up = np.array([1.0, 0.0, 0.0, 0.0])
    return Readings(0.0, up, np.zeros(3), np.zeros(3), robot.posture[7:], zero, zero, None)


@pytest.mark.parametrize("robot", [GO2], ids=lambda robot: robot.name)
class TestTheRobotsOwnController:
    def test_it_is_released_before_anything_is_sent(self, robot, domain):
        end, link = DdsRobot(robot, "lo", domain, "normal"), DdsLink(robot, "lo", domain)
        with threads(lambda: end.publish(still(robot), 1.0)):
            assert link.receive(5.0) is not None
            time.sleep(0.1)
            assert link.others() > 5
            done = link.take_over()
            assert done == (
                'the robot\'s own controller "normal" was released; nobody else commands the motors'
            )
            assert link.take_over().startswith("the robot runs no controller of its own")
        assert end.commands(0.0) == []  # neither its own nor ours

    def test_one_that_does_not_end_is_not_fought(self, robot, domain, monkeypatch):
        monkeypatch.setattr(motion_switcher, "_ANSWERS_WITHIN", 0.1)
        end, link = DdsRobot(robot, "lo", domain, "ai"), DdsLink(robot, "lo", domain)
        end._switcher.serve = lambda: None
        with (
            threads(lambda: end.publish(still(robot), 1.0)),
            pytest.raises(Error, match=r"another program writes rt/lowcmd \(\d+ commands"),
        ):
            link.take_over()

    def test_another_program_is_not_fought(self, robot, domain):
        end, link = DdsRobot(robot, "lo", domain), DdsLink(robot, "lo", domain)
        other = DdsLink(robot, "lo", domain)
        with (
            threads(lambda: end.publish(still(robot), 1.0), lambda: other.send(holding(robot))),
            pytest.raises(Error, match=r"another program writes rt/lowcmd \(\d+ commands"),
        ):
            link.take_over()


def test_without_a_motion_switcher(domain, monkeypatch):
    """On a robot's network that is an error unless somebody has ended it by hand."""
    monkeypatch.setattr(motion_switcher, "FOUND_WITHIN", 0.2)
    link = DdsLink(GO2, "lo", domain)
    assert link.take_over().startswith("no motion switcher answers; nobody else")
    link._ends.on_loopback = False
    with pytest.raises(Error, match=r"no motion switcher of the robot answers.*--released"):
        link.take_over()
    assert link.take_over(released=True)


def test_the_makers_own_request_is_answered(domain):
    """Types as the maker's SDK declares them, field by field."""
    from cyclonedds.domain import DomainParticipant
    from cyclonedds.pub import DataWriter
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic

    end = DdsRobot(GO2, "lo", domain, "normal")
    asks = DomainParticipant(domain)
    reader = DataReader(asks, Topic(asks, "rt/api/motion_switcher/response", sdk.Response_))
    writer = DataWriter(asks, Topic(asks, "rt/api/motion_switcher/request", sdk.Request_))
    answers = []
    with threads(lambda: end.publish(still(GO2), 1.0)):
        for number, operation in enumerate((1001, 1003, 1001, 1999)):
            until = time.monotonic() + 10.0
            while len(answers) == number and time.monotonic() < until:
                identity = sdk.RequestIdentity_(number, operation)
                header = sdk.RequestHeader_(
                    identity, sdk.RequestLease_(0), sdk.RequestPolicy_(0, False)
                )
                writer.write(sdk.Request_(header, "{}", []))
                time.sleep(0.2)
                found = [r for r in reader.take(10) if r.header.identity.id == number]
                answers += [(r.header.status.code, r.data) for r in found][:1]
    held, released = '{"form": "0", "name": "normal"}', '{"form": "0", "name": ""}'
    assert answers == [(0, held), (0, ""), (0, released), (3203, "")]


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
