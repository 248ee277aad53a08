"""A plan's summary names the phases of its schedule."""

from __future__ import annotations

import pytest

from llsrbm.analysis.summary import plan_summary
from tests.llsrbm.synthetic import TWO_HOPS, TWO_HOPS_DURATIONS, synthetic_plan


def test_phases_of_any_schedule():
    plan = synthetic_plan(schedule=TWO_HOPS, durations=TWO_HOPS_DURATIONS)
    summary = plan_summary(plan)
    assert summary["phase_durations_s"] == pytest.approx(list(TWO_HOPS_DURATIONS))
    assert [phase["name"] for phase in summary["phases"]] == list(TWO_HOPS.names)
    assert [phase["feet"] for phase in summary["phases"][1:3]] == [["LH", "RH"], []]
    assert [p["duration_s"] for p in summary["phases"]] == summary["phase_durations_s"]
    assert summary["request"] == plan.jump.as_dict()
