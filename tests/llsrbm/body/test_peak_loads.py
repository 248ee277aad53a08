"""The joint that is loaded most, of plans made by hand."""

from dataclasses import replace

import numpy as np
import pytest

from llsrbm.analysis.summaries import planned_peak_load, planned_torque_shares
from tests.llsrbm.synthetic import TWO_HOPS, TWO_HOPS_DURATIONS, synthetic_plan


@pytest.fixture(scope="module")
def plan():
    plan = synthetic_plan(intervals=5, durations=(0.5, 0.5, 0.5))
    return replace(plan, joint_torque=np.ones_like(plan.joint_torque))


def loaded(plan, knot, joint, torque, limit=40.0):
    torques, limits = plan.joint_torque.copy(), plan.joint_torque_limit.copy()
    torques[knot, joint], limits[knot, joint] = torque, limit
    return replace(plan, joint_torque=torques, joint_torque_limit=limits)


@pytest.mark.parametrize(
    ("knot", "phase", "words"),
    [
        (1, "take-off", "in take-off at 0.15 s"),
        (4, "take-off", "at lift-off"),
        (5, "flight", "at lift-off"),
        (7, "flight", "in flight at 0.75 s"),
        (9, "flight", "at touchdown"),
        (10, "landing", "at touchdown"),
        (14, "landing", "in landing at 1.45 s"),
    ],
)
def test_the_most_loaded_joint(plan, knot, phase, words):
    peak = planned_peak_load(loaded(plan, knot, 2, -34.0))
    assert (peak.joint, peak.phase, peak.torque, peak.available) == ("LF_C", phase, -34.0, 40.0)
    assert peak.time == pytest.approx(0.1 * knot + 0.05)
    assert peak.in_words() == f"34 of 40 Nm {words} (85 %)"


@pytest.mark.parametrize(
    ("knot", "words"),
    [
        (4, "at lift-off"),  # of the front feet
        (7, "in rear push at 0.55 s"),
        (12, "in flight at 0.75 s"),
        (15, "at touchdown"),
        (17, "in rebound at 1.10 s"),
        (25, "at touchdown"),  # of the front feet
        (29, "at touchdown"),  # of the hind feet
    ],
)
def test_events_of_any_foot(knot, words):
    plan = synthetic_plan(intervals=5, schedule=TWO_HOPS, durations=TWO_HOPS_DURATIONS)
    plan = replace(plan, joint_torque=np.ones_like(plan.joint_torque))
    peak = planned_peak_load(loaded(plan, knot, 2, -34.0))
    assert peak.in_words() == f"34 of 40 Nm {words} (85 %)"


def test_a_joint_that_is_too_fast_for_any_torque(plan):
    peak = planned_peak_load(loaded(plan, 7, 3, 0.5, limit=0.0))
    assert peak.ratio == np.inf
    assert peak.in_words(frozenset({"RF_A"})) == (
        "0 of 0 N in flight at 0.75 s (too fast for any torque)"
    )


def test_what_is_not_known(plan):
    unknown = replace(plan, joint_torque=None, joint_torque_limit=None)
    assert planned_peak_load(unknown) is None
    assert planned_torque_shares(unknown) == {}
