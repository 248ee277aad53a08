"""The counts behind published tables, by outcomes made by hand."""

import numpy as np
import pytest

from benchmarks import pushes
from benchmarks import range as requests_of
from benchmarks.counting import Counts, count, seeds_of
from tests.llsrbm.synthetic_rollout import synthetic_rollout

LANDED = {"status": "landed", "strict": True, "recovered": True}
MOVED = {"status": "landed", "strict": False, "recovered": True}
LEANS = {"status": "landed", "strict": False, "recovered": False}
FELL = {"status": "fell", "strict": False, "recovered": False}


def test_standing_is_not_strict():
    rows = [LANDED, MOVED, LEANS, LEANS, FELL]
    assert count(rows) == Counts(5, 5, stand=4, strict=1, recovered=2)


def test_requests_without_an_outcome_count_as_requests():
    rows = [LANDED, {"planned": False}]
    assert count(rows) == Counts(2, 1, stand=1, strict=1, recovered=1)


def test_outcomes_count_as_their_figures_do():
    outcome = synthetic_rollout().outcome
    assert count([outcome]) == count([vars(outcome)])


def test_seeds():
    assert list(seeds_of("5:8")) == [5, 6, 7]


def test_half_of_the_requests_are_combined_and_the_same_each_time():
    made = requests_of.requests("anymal", 40, 7)
    assert made == requests_of.requests("anymal", 40, 7)
    motions = [sum(name in request for name in requests_of.COMPONENTS) for request in made]
    assert motions == [1, 4] * 20
    assert len({request["seed"] for request in made}) == 40


def test_the_table_of_the_range_counts_strict_landings_of_all_requests():
    figures = {
        "yaw_error_at_touchdown": 0.01,
        "saturated_fraction": 0.0,
        "unsolved_ticks": 0,
        "moved": False,
        "certified": True,
    }
    rows = [
        {"robot": "r", "estimator": "imu", "kind": kind, "planned": True, **figures, **outcome}
        for kind in requests_of.KINDS
        for outcome in (LANDED, LEANS, FELL)
    ]
    rows.append({"robot": "r", "estimator": "imu", "kind": "combined", "planned": False})
    *_, combined, every = requests_of.table(rows)
    assert combined.split()[1:11] == [
        "imu",
        "combined",
        "4",
        "3",
        "3",
        "1",
        "2",
        "1",
        "33.3%",
        "25.0%",
    ]
    assert every.split()[1:11] == ["imu", "all", "7", "6", "6", "2", "4", "2", "33.3%", "28.6%"]


def test_eighteen_of_twenty_seeds_recover_on_a_rung_that_passes():
    assert pushes.allowed_failures(20) == 2
    assert pushes.allowed_failures(9) == 0


@pytest.mark.parametrize("highest", [-1, 0, 7, len(pushes.LADDER) - 1])
@pytest.mark.parametrize("guess", [0, 5, len(pushes.LADDER) - 1])
def test_the_ladder_finds_the_highest_rung_that_passes(highest, guess):
    assert pushes.largest(lambda rung: rung <= highest, guess) == highest
    assert np.allclose(np.diff(np.log(pushes.LADDER)), np.log(pushes.STEP))
