"""Which jumps can be planned, without planning them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from llsrbm.atlas import feasible
from llsrbm.atlas.feasible import Track, feasible_of, learned, tracks, values_of, why_unknown
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from llsrbm.robots.schema import robot_files

JUMP = Jump(twist=0.3, forward=0.1)


@pytest.fixture(scope="module")
def anymal():
    return load_robot("anymal")


def score(found, jump, limits, robot):
    return found.scores(found.scaled(values_of(jump, limits, robot)[None]))[0]


WITHOUT = {"g1", "talos"}  # robots with arms: no samples have been drawn yet


@pytest.mark.parametrize("name", sorted(WITHOUT))
def test_robots_without_one_say_so(name):
    robot = load_robot(name)
    assert why_unknown(Jump(robot=name), {}, robot) == "of this robot"


@pytest.mark.parametrize("name", sorted(robot_files().keys() - WITHOUT))
def test_the_others_have_one_and_can_do_their_example(name):
    robot = load_robot(name)
    jump = Jump(robot=name, **robot.file.example.model_dump())
    found = tracks(jump, {}, robot)
    assert why_unknown(jump, {}, robot) == ""
    for field, track in found.items():
        low, high = getattr(robot.file.task, field)
        assert (track.values[0], track.values[-1]) == (low, high)
        assert any(a <= getattr(jump, field) <= b for a, b in track.intervals)


def test_left_and_right_are_alike(anymal):
    found = feasible_of(anymal)
    jump = Jump(twist=2.5, forward=0.4, lateral=0.2, height=0.1)
    mirrored = replace(jump, twist=-2.5, lateral=-0.2)
    assert score(found, jump, {}, anymal) == pytest.approx(score(found, mirrored, {}, anymal))


def test_weak_drives_leave_less_of_the_twist(anymal):
    def length(share):
        (ends,) = tracks(JUMP, {"torque_share": share}, anymal)["twist"].intervals
        return ends[1] - ends[0]

    assert length(0.4) < 0.8 * length(0.85)


def test_a_plan_counts_around_it_and_nowhere_else(anymal):
    limits = {"torque_share": 0.4}
    before = feasible_of(anymal)
    hard = replace(JUMP, twist=math.pi)
    assert score(before, hard, limits, anymal) < 0
    after = learned(before, hard, limits, anymal, planned=True)
    assert score(after, hard, limits, anymal) > 0
    assert score(after, replace(hard, twist=3.0), limits, anymal) > 0
    assert score(after, JUMP, limits, anymal) == pytest.approx(
        score(before, JUMP, limits, anymal), abs=1e-3
    )
    again = learned(after, hard, limits, anymal, planned=False)
    assert score(again, hard, limits, anymal) < 0
    assert learned(again, hard, limits, anymal, planned=False) is again


@pytest.mark.parametrize(
    ("changes", "limits", "why"),
    [
        ({"type": "hops", "hops": 2}, {}, "type of jump"),
        ({"model": "srbm"}, {}, "this model"),
        ({}, {"reach_max": 0.5}, "another reach max"),
    ],
)
def test_what_was_not_sampled_is_said(anymal, changes, limits, why):
    jump = replace(JUMP, **changes)
    assert why in why_unknown(jump, limits, anymal)
    assert tracks(jump, limits, anymal) == {}
    found = feasible_of(anymal)
    assert learned(found, jump, limits, anymal, planned=False) is found


def test_held_arms_matter_to_robots_that_have_some(anymal):
    held = replace(JUMP, arms="held")
    assert why_unknown(held, {}, anymal) == ""
    assert why_unknown(replace(held, robot="g1"), {}, load_robot("g1")) == "with the arms held"


def test_a_robot_with_other_numbers_has_none(anymal, monkeypatch):
    monkeypatch.setattr(feasible, "numbers_key", lambda robot: "another")
    feasible_of.cache_clear()
    try:
        assert why_unknown(JUMP, {}, anymal) == "of this robot"
    finally:
        feasible_of.cache_clear()


def test_ends_lie_where_the_odds_are_even():
    values = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
    both = Track(values, np.array([-1.0, 1.0, 1.0, -3.0, 1.0]))
    assert both.intervals == ((0.5, 2.25), (3.75, 4.0))
    assert Track(values, np.ones(5)).intervals == ((0.0, 4.0),)
    assert Track(values, -np.ones(5)).intervals == ()
