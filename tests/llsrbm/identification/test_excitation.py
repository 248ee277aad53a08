"""The excitation: within limits, smooth, and a whole play whose log is identified."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from benchmarks.identify import GOALS, errors, hidden
from llsrbm.control.readings import Readings
from llsrbm.errors import InputError
from llsrbm.identification import identify, read_log
from llsrbm.identification.excitation import Excitation, sines
from llsrbm.player import Player
from llsrbm.player.mcap import write
from llsrbm.robots import load_robot
from llsrbm.robots.link_shapes import LinkShapes
from llsrbm.wire.simulated_robot import Conditions, DirectLink, SimulatedRobot
from tests.llsrbm.identification.synthetic import GO2

LEVEL = np.array([1.0, 0, 0, 0]), np.zeros(3), np.array([0, 0, 9.81])


@pytest.mark.parametrize("name", ["go2", "g1"])
def test_it_stays_within_stops_speeds_torques_and_apart(name):
    robot = load_robot(name)
    found = sines(robot, 8.0)
    q, v, _ = found.at(np.linspace(0.0, 8.0, 331))
    lower, upper = robot.joint_stops
    assert ((q > lower) & (q < upper)).all()
    assert (np.abs(v) < 0.4 * robot.speed_limit).all()
    assert (np.abs(found.torques()) < 0.5 * robot.torque_limit).all()
    assert (np.abs(q - found.posture).max(axis=0) > 0.02).all()
    base = np.tile([*robot.posture[:3], 0, 0, 0, 1], (len(q), 1))
    assert LinkShapes.of(robot).least(np.hstack([base, q]))[0] > 0.003
    assert v[0] == pytest.approx(0.0, abs=1e-9)
    assert v[-1] == pytest.approx(0.0, abs=1e-9)


def loop(robot):
    """Mass matrix of the joints and the loop's gains, both as a command has them."""
    excitation = Excitation(robot, 60.0)
    first, joints = excitation.first, len(robot.joint_names)
    still = Readings(0.0, *LEVEL, first.joints, np.zeros(joints), np.zeros(joints), None)
    about = excitation.command(0.0, still).tau

    def gains(field):
        step = 1e-4 * np.eye(joints)
        moved = [replace(still, **{field: getattr(still, field) + off}) for off in step]
        return np.array([(about - excitation.command(0.0, each).tau) / 1e-4 for each in moved]).T

    q = np.concatenate([robot.posture[:3], [0, 0, 0, 1], first.joints])
    M = np.triu(pin.crba(robot.model, robot.model.createData(), q))[6:, 6:]
    return M + np.triu(M, 1).T, gains("q"), gains("dq")


@pytest.mark.parametrize("name", ["g1", "go2"])
def test_joints_in_a_row_do_not_swing_faster_than_their_loops(name):
    """However far rotors are from the file's, and with commands 5 ms late."""
    robot = load_robot(name)
    M, stiffness, damping = loop(robot)
    for share in (0.7, 1.3):
        inverse = np.linalg.inv(M + (share - 1) * np.diag(robot.armature))
        period, late = 1e-3, 5
        joints = len(M)
        x, v = np.zeros((2, joints))
        x[:] = 0.01
        commands = [np.zeros(joints)] * late
        largest = []
        for _ in range(600):
            commands.append(-stiffness @ x - damping @ v)
            v = v + period * inverse @ commands[-1 - late]
            x = x + period * v
            largest.append(np.abs(x).max())
        assert largest[-1] < 1e-4, name


def test_speeds_and_accelerations_are_derivatives():
    found, step = sines(GO2, 6.0), 1e-6
    times = np.array([0.3, 0.9, 2.0, 5.2, 5.9])
    _, v, a = found.at(times)
    ahead, behind = found.at(times + step), found.at(times - step)
    assert (ahead[0] - behind[0]) / (2 * step) == pytest.approx(v, abs=1e-6)
    assert (ahead[1] - behind[1]) / (2 * step) == pytest.approx(a, abs=1e-5)


@pytest.mark.parametrize("seconds", [1.0, 1e4])
def test_durations_out_of_range_are_refused(seconds):
    with pytest.raises(InputError, match="duration: expected 5 to 600 s"):
        sines(GO2, seconds)


@pytest.mark.nightly
def test_a_play_on_a_hung_robot_shows_its_drives(tmp_path):
    """Over the wire's delays, 3 ms on average and a step until motors look for commands."""
    pytest.importorskip("foxglove", reason="needs the extra llsrbm[mcap]")
    pytest.importorskip("mcap", reason="needs the extra llsrbm[mcap]")
    drives = hidden(GO2, 41)
    robot = SimulatedRobot(drives.robot, Conditions(0.003, 0.0005), 41, hung=True)
    touched = []
    robot.observers.append(lambda tick: touched.extend(tick.result.touches))
    player = Player(Excitation(GO2, 8.0), DirectLink(robot), lambda: robot.time)
    ended = player.run()
    assert ended.reason == ""
    assert not touched
    path = tmp_path / "play.mcap"
    write(player.log, path, {"tier": Excitation.name})
    log = read_log(path, GO2)
    assert log.gyro is not None
    assert log.usable.sum() * log.period == pytest.approx(8.0, abs=0.01)
    found = identify(GO2, log)
    off = errors(drives, found)
    assert off["armature"] < GOALS["armature"]
    assert off["friction"] < GOALS["friction"]
    assert found.delay == pytest.approx(0.003, abs=5e-4)
    drive = found.joints["FL_calf_joint"]
    assert 0 < drive.armature_error < 0.1 * drive.armature
    # Another tier's robot stands, and what it does then says nothing of its drives.
    path.unlink()
    write(player.log, path, {"tier": "table"})
    assert not read_log(path, GO2).usable.any()
    with pytest.raises(InputError, match="expected a log of anymal, got another robot's joints"):
        read_log(path, load_robot("anymal"))
