"""Figures of plans and rollouts as JSON can hold them."""

import json
from dataclasses import fields, replace

import numpy as np
import pytest

from llsrbm.analysis.summaries import rollout_summary
from llsrbm.motion.outcome import Outcome
from tests.llsrbm.synthetic_rollout import synthetic_rollout

# As the contract has them, in its order.
KEYS = [
    "status", "final_yaw_error", "final_position_error", "final_tilt", "touchdown_true_s",
    "touchdown_detected_s", "false_touchdowns", "peak_torque_ratio", "peak_speed_ratio",
    "saturated_fraction", "tick_median_s", "tick_p99_s", "real_time_factor", "control_rate_hz",
    "strict", "unsolved_ticks", "recovered", "replans", "replan_median_s", "replan_p95_s",
]  # fmt: skip


@pytest.fixture(scope="module")
def rollout():
    return synthetic_rollout(seed=7)


def test_the_contracts_keys_come_first(rollout):
    summary = rollout_summary(rollout)
    assert list(summary)[: len(KEYS)] == KEYS
    assert {field.name for field in fields(Outcome)} <= set(summary)


def test_values_are_the_outcomes(rollout):
    summary = json.loads(json.dumps(rollout_summary(rollout), allow_nan=False))
    for field in fields(Outcome):
        value = getattr(rollout.outcome, field.name)
        assert summary[field.name] == (list(value) if isinstance(value, tuple) else value)
    assert summary["duration_s"] == pytest.approx(2.5)
    assert summary["scenario"]["seed"] == 7
    assert summary["disturbance"]["torque_delay_ticks"] == 1


def test_what_there_is_not_is_null(rollout):
    outcome = replace(
        rollout.outcome,
        touchdown_true_s=None,
        yaw_error_at_touchdown=np.float64(np.nan),
        final_tilt=np.inf,
        foot_touchdown_s=(None, np.nan, 0.9, 0.9),
        trunk_touched=np.True_,
    )
    summary = rollout_summary(replace(rollout, outcome=outcome))
    text = json.dumps(summary, allow_nan=False)
    back = json.loads(text)
    assert back["touchdown_true_s"] is None
    assert back["yaw_error_at_touchdown"] is None
    assert back["final_tilt"] is None
    assert back["foot_touchdown_s"] == [None, None, 0.9, 0.9]
    assert back["trunk_touched"] is True
