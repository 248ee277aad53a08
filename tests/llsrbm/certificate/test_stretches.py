"""Motions that are checked stretch by stretch: the same findings, memory that does not grow."""

import tracemalloc
from dataclasses import asdict, replace

import numpy as np
import pytest

import llsrbm
from llsrbm import cli
from llsrbm.certificate import sampled_motion
from llsrbm.certificate.picture import write_picture
from llsrbm.motion.whole_body import motion_at, motion_of_states, velocities
from llsrbm.robots import load_robot
from tests.llsrbm.certificate.test_power import robot_file
from tests.llsrbm.formats.jumps import planned, simulated

PNG = b"\x89PNG"


def assert_alike(one, other):
    for mine, theirs in zip(one, other, strict=True):
        tie = mine.name in ("self_distance", "clearance")  # of left and right, to coal's 1e-9 m
        for name, value in vars(mine).items():
            if tie and name in ("where", "time_s"):
                continue
            if isinstance(value, float):
                assert value == pytest.approx(getattr(theirs, name), rel=1e-9, abs=1e-8), mine
            else:
                assert value == getattr(theirs, name)
    powers = [asdict(each.power) for each in (one, other)]
    known = [(power.pop("heat_j") or {}) | power for power in powers]
    assert known[0].keys() == known[1].keys()
    for name, value in known[0].items():
        assert value == (None if value is None else pytest.approx(known[1][name], rel=1e-9))


def foreign():
    """Go2's simulated jump as another tool would give it, played so fast that limits break."""
    rollout = simulated("go2")
    time = np.arange(rollout.time[0], rollout.time[-1], 0.02)
    at = motion_at(rollout, time)
    faster = (time - time[0]) / 1.7
    found = motion_of_states(
        load_robot("go2"), "hand", faster, at.qpos, velocities(faster, at.qpos)
    )
    return replace(found, contact=at.contact)


@pytest.mark.parametrize("make", [lambda: planned("go2"), lambda: simulated("anymal"), foreign])
@pytest.mark.parametrize("instants", [11, 97])
def test_short_stretches_find_the_same(make, instants, monkeypatch):
    motion = make()
    whole = llsrbm.certify(motion)
    monkeypatch.setattr(sampled_motion, "AT_ONCE", instants)
    assert_alike(whole, llsrbm.certify(motion))


def test_heat_adds_up_over_stretches(tmp_path, monkeypatch):
    path = str(robot_file(tmp_path, "heat = 20.0"))
    plan = llsrbm.plan(llsrbm.Jump(robot=path, forward=0.1), draft=True, explains=False)
    whole = llsrbm.certify(plan)
    assert whole["winding_heat"].worst > 0
    assert whole.power.heat_j is not None
    monkeypatch.setattr(sampled_motion, "AT_ONCE", 97)
    assert_alike(whole, llsrbm.certify(plan))


def standing(seconds):
    """Go2 that stands and moves a calf to and fro, at 50 frames/s."""
    robot, time = load_robot("go2"), np.arange(0.0, seconds, 0.02)
    q = robot.posture
    qpos = np.tile(np.concatenate([q[:3], q[[6, 3, 4, 5]], q[7:]]), (len(time), 1))
    qpos[:, 9] += 0.05 * np.sin(5 * time)
    return motion_of_states(robot, "hand", time, qpos, velocities(time, qpos))


def test_memory_does_not_grow_with_the_length():
    def most(motion):
        tracemalloc.start()
        try:
            llsrbm.certify(motion)
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    most(standing(3.0))  # what is kept of the robot
    short, long = most(standing(3.0)), most(standing(60.0))
    assert long < short + 15e6  # bytes; 60 s at 1 kHz take 40 MB of states alone


def test_courses_show_where_a_limit_breaks():
    motion = foreign()
    certificate = llsrbm.certify(motion)
    found, profile = certificate["joint_speed"], certificate.profiles["joint_speed"]
    assert found.holds is False
    broken = ~profile.holds
    assert (broken == (profile.worst > profile.allowed)).all()
    assert broken.any()
    assert not broken.all()
    assert profile.worst.max() == found.worst
    (at,) = np.flatnonzero((profile.begin <= found.time_s) & (found.time_s < profile.end))
    assert profile.worst[at] == found.worst
    assert (profile.begin[1:] == profile.end[:-1]).all()
    # The simulator's speeds, 1.7 times as fast, by themselves.
    limit, knots = load_robot("go2").speed_limit, motion.time
    shares = (np.abs(motion.qvel[:, 6:]) / limit).max(axis=1)
    for begin, end in zip(profile.begin[~broken], profile.end[~broken], strict=True):
        inside = (knots > begin) & (knots < end)
        assert (shares[inside] <= profile.allowed).all()
    assert "friction" not in certificate.profiles  # nothing is known of it


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_a_picture_of_it(tmp_path, suffix):
    path = tmp_path / f"broken.{suffix}"
    write_picture(llsrbm.certify(foreign()), path, "mine")
    content = path.read_bytes()
    assert content.startswith(PNG) if suffix == "png" else b"<svg" in content


def test_the_command_draws(tmp_path, capfd, refused):
    file, picture = tmp_path / "motion.csv", tmp_path / "picture.png"
    llsrbm.export(planned("go2"), file, "unitree-csv")
    cli.main(["check", str(file), "--robot", "go2", "--fps", "60", "--plot", str(picture)])
    assert picture.read_bytes().startswith(PNG)
    capfd.readouterr()
    assert "a.bmp: expected a name that ends in one of .png" in refused(
        "check", str(file), "--robot", "go2", "--fps", "60", "--plot", "a.bmp"
    )
