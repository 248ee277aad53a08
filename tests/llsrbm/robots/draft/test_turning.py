"""Tables of flips in first robot files: which robots get one, and why others do not."""

import tomllib

import numpy as np
import pytest

from llsrbm.mechanics import GRAVITY
from llsrbm.robots import load_robot
from llsrbm.robots.draft.turning import (
    IN_THE_AIR,
    SPEED,
    WORK,
    FlipEstimate,
    estimate,
    left_out,
    turning_table,
)
from tests.llsrbm.robots.draft.first_files import first_file, written


@pytest.mark.parametrize("name", ["a1", "go1"])
def test_robots_that_flip_get_a_table_like_their_own(name):
    found = first_file(name)
    assert "Guessed: a flip takes" in found.text.partition("[turning]")[0].splitlines()[-1]
    table, own = found.robot.file.turning, load_robot(name).file.turning
    assert table.axes == ("pitch",)
    for name in ("distance", "lower", "upper"):
        np.testing.assert_allclose(getattr(table.reach, name), getattr(own.reach, name), atol=0.021)
    assert table.reach.standing == own.reach.standing
    assert table.timing.takeoff == own.timing.takeoff


def test_weak_robots_get_none_and_a_line_that_says_why():
    found = first_file("anymal_c")
    assert "turning" not in tomllib.loads(found.text)
    (line,) = [line for line in found.text.splitlines() if line.startswith("# No [turning]: ")]
    assert "times as much; robots that flip have" in line
    assert line.removeprefix("# No [turning]: ").rstrip(".") in found.said


def test_legs_that_do_not_fold_are_no_reason_to_refuse_a_robot(tmp_path):
    text, stop = load_robot("a1").urdf_path.read_text(), 'lower="-2.6965336943312392"'
    assert stop in text
    urdf = tmp_path / "a1.urdf"
    urdf.write_text(text.replace(stop, 'lower="-1.9"'))
    found = written(tmp_path / "a1.toml", str(urdf))
    why = "stops let no leg fold until its foot is 0.16 m below its hip"
    assert f"# No [turning]: {why}" in found.text
    assert f"left out turning: {why}" in found.said


def test_no_flips_by_drives_that_are_guessed():
    found = first_file("solo12")
    why = (
        "the URDF lacks drives that can be meant, limits.torque and limits.joint_speed are guessed"
    )
    assert f"# No [turning]: {why}" in found.text
    assert f"left out turning: {why}" in found.said


def test_shipped_robots_without_flips_are_refused_by_the_estimate():
    """With the drives of their files, for a pitch inertia that is less than when they stand."""
    for name in ("anymal", "anymal_c", "solo12"):
        robot = load_robot(name)
        legs, length = robot.leg_joint_index[0], robot.file.reach.distance[1] / 0.91
        drives = robot.torque_limit[legs], robot.speed_limit[legs]
        assert left_out(estimate(robot.mass, 0.75 * robot.inertia[1, 1], length, *drives))


def test_the_flight_takes_least_energy():
    """Of the speeds up and of turning; the height is the same."""
    mass, inertia, drives = 15.0, 0.4, np.array([20.0, 20.0, 40.0])
    flip = estimate(mass, inertia, 0.43, drives, drives)

    def kinetic(flight):
        up, turning = GRAVITY * flight / 2, IN_THE_AIR / flight
        return mass * up**2 / 2 + inertia * turning**2 / 2

    assert kinetic(flip.flight) < min(kinetic(0.95 * flip.flight), kinetic(1.05 * flip.flight))
    rise = flip.energy - kinetic(flip.flight)
    assert 0.1 * mass * GRAVITY < rise < 0.43 * mass * GRAVITY


def test_robots_alike_in_proportion_are_judged_alike():
    """Twice as long, 8 times as heavy: torques go with the fourth power, speeds with 1 / root."""
    torque, speed = np.array([24.0, 24.0, 36.0]), np.array([30.0, 30.0, 20.0])
    small = estimate(13.0, 0.38, 0.44, torque, speed)
    large = estimate(8 * 13.0, 32 * 0.38, 0.88, 16 * torque, speed / np.sqrt(2))
    assert large.work / large.energy == pytest.approx(small.work / small.energy)
    assert large.fastest / large.knee_speed == pytest.approx(small.fastest / small.knee_speed)


@pytest.mark.parametrize(
    ("work", "fastest", "said"),
    [
        (1.01 * WORK, 1.01 * SPEED, ""),
        (0.99 * WORK, 2 * SPEED, "a flip takes 100 J"),
        (2 * WORK, 0.99 * SPEED, "at lift-off of a flip knees open at 10.0 rad/s"),
    ],
    ids=["enough", "too weak", "too slow"],
)
def test_torque_and_speed_are_both_needed(work, fastest, said):
    why = left_out(FlipEstimate(0.4, 100.0, 100.0 * work, 10.0, 10.0 * fastest))
    assert why.startswith(said)
    assert bool(why) == bool(said)


def test_the_table_is_in_proportion_to_the_legs():
    small, large = turning_table(0.4, 0.0), turning_table(0.8, 0.0)
    np.testing.assert_allclose(
        large["reach"]["distance"], 2 * np.array(small["reach"]["distance"]), atol=0.011
    )
    assert turning_table(0.4, 0.1)["reach"]["upper"][1] == pytest.approx(
        small["reach"]["upper"][1] + 0.1, abs=0.011
    )
