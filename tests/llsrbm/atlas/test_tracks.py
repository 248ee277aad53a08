"""Which jumps can be planned, without planning them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from llsrbm.atlas.tracks import Track, learned, tracks, why_unknown
from llsrbm.planning.whole_body.feasible import feasible_of
from llsrbm.planning.whole_body.learned_file import outcomes_of
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from llsrbm.robots.drives.variants import with_drives
from tests.llsrbm.atlas.classifiers import BORDER, learned_of

JUMP = Jump(twist=0.3, forward=0.1)


@pytest.fixture
def anymal():
    """The robot, of which alone something is known."""
    robot = load_robot("anymal")
    with learned_of(robot):
        yield robot


def test_of_robots_without_a_table_nothing_is_known(anymal):
    """Of another robot's numbers none is used."""
    slider = load_robot("slider")
    of_slider = Jump(robot="slider")
    assert why_unknown(of_slider, {}, slider) == "of this robot"
    assert tracks(of_slider, {}, slider) == {}
    others = with_drives(anymal, 1.2, 1.0)
    assert feasible_of(anymal) is not None
    assert feasible_of(others) is None
    assert why_unknown(JUMP, {}, others) == "of this robot"


@pytest.mark.parametrize("forward", [-0.2, 0.0, 0.4])
def test_along_a_slider_the_ends_are_where_the_border_is(anymal, forward):
    (ends,) = tracks(replace(JUMP, forward=forward), {}, anymal)["twist"].intervals
    largest = BORDER * anymal.file.task.twist[1]
    np.testing.assert_allclose(ends, (-largest, largest), rtol=0.03)


def test_tracks_are_of_the_whole_ranges(anymal):
    found = tracks(JUMP, {}, anymal)
    for field in ("forward", "lateral", "height"):
        ends = getattr(anymal.file.task, field)
        assert (found[field].values[0], found[field].values[-1]) == ends
        assert found[field].intervals == (ends,)


def test_left_and_right_are_alike(anymal):
    """Whatever the weights."""
    plain = feasible_of(anymal)
    found = replace(plain, weights=np.random.default_rng(0).normal(size=len(plain.weights)))
    jump = Jump(twist=2.5, forward=0.4, lateral=0.2, height=0.1)
    mirrored = replace(jump, twist=-2.5, lateral=-0.2)
    assert found.score(jump) == pytest.approx(found.score(mirrored))


def test_a_plan_counts_around_it_and_nowhere_else(anymal):
    before = feasible_of(anymal)
    hard = replace(JUMP, twist=math.pi)
    assert before.score(hard) < 0
    after = learned(before, hard, {}, anymal, planned=True)
    assert after.score(hard) > 0
    assert after.score(replace(hard, twist=3.0)) > 0
    assert after.score(JUMP) == pytest.approx(before.score(JUMP), abs=1e-3)
    again = learned(after, hard, {}, anymal, planned=False)
    assert again.score(hard) < 0
    assert learned(again, hard, {}, anymal, planned=False) is again


def test_the_tables_that_ship_know_their_own_jumps():
    """Better than the same answer to all of them."""
    robot = load_robot("go2")
    outcomes, found = outcomes_of(robot), feasible_of(robot)
    solved, refused = (found.scores(found.scaled(x)) for x in (outcomes.requests, outcomes.refused))
    right = (solved > 0).sum() + (refused < 0).sum()
    assert right / (len(solved) + len(refused)) > 0.9
    assert len(refused) > 20
    assert (refused < 0).mean() > 0.6


@pytest.mark.parametrize(
    ("changes", "limits", "why"),
    [
        ({"type": "hops", "hops": 2}, {}, "type of jump"),
        ({"model": "srbm"}, {}, "this model"),
        ({"stones": {"LF": (0.05, 0.0)}}, {}, "with feet landing elsewhere"),
        ({}, {"reach_max": 0.5}, "another reach max"),
        ({}, {"torque_share": 0.4}, "another torque share"),
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


def test_ends_lie_where_the_odds_are_even():
    values = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
    both = Track(values, np.array([-1.0, 1.0, 1.0, -3.0, 1.0]))
    assert both.intervals == ((0.5, 2.25), (3.75, 4.0))
    assert Track(values, np.ones(5)).intervals == ((0.0, 4.0),)
    assert Track(values, -np.ones(5)).intervals == ()
