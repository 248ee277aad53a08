"""Room that a robot takes, and how far two motions of it are apart."""

from dataclasses import replace

import numpy as np
import pytest

from app.picture.bounds import apart, around_default, outermost
from llsrbm.robots import load_robot
from tests.app.picture.pictures import planned

ROBOT = load_robot("anymal")


def test_the_outermost_points_reach_as_far_as_all():
    points = around_default(ROBOT)
    few = outermost(points)
    assert len(few) <= 64
    assert few.max(axis=0) == pytest.approx(points.max(axis=(0, 1, 2)), abs=0.02)
    assert few.min(axis=0) == pytest.approx(points.min(axis=(0, 1, 2)), abs=0.02)


def test_a_motion_beside_itself_is_as_far_apart_as_it_was_moved():
    frames = planned().frames
    assert apart(ROBOT, frames, frames, frames.time).max() < 1e-9
    moved = replace(frames, body_position=frames.body_position + np.array([0.0, 0.03, 0.0]))
    assert apart(ROBOT, frames, moved, frames.time) == pytest.approx(0.03)


def test_before_and_after_a_motion_its_ends_hold():
    frames = planned().frames
    long = np.append(frames.time, frames.end + 1)
    shifted = frames.body_position + np.linspace(0, 0.1, len(frames.time))[:, None, None]
    distance = apart(ROBOT, frames, replace(frames, body_position=shifted), long)
    assert (distance[-1] == distance[-2]).all()
    assert distance[-1].max() == pytest.approx(0.1 * np.sqrt(3))
