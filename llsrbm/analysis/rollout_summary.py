"""A rollout in figures, for the command line and for scripts."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from llsrbm.analysis.diagnosis import diagnose
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.trajectory import json_value

# What the contract promises stands first, in its order; further figures may follow.
PROMISED = (
    "status",
    "final_yaw_error",
    "final_position_error",
    "final_tilt",
    "touchdown_true_s",
    "touchdown_detected_s",
    "false_touchdowns",
    "peak_torque_ratio",
    "peak_speed_ratio",
    "saturated_fraction",
    "tick_median_s",
    "tick_p99_s",
    "real_time_factor",
    "control_rate_hz",
    "strict",
    "unsolved_ticks",
    "recovered",
    "replans",
    "replan_median_s",
    "replan_p95_s",
)


def rollout_summary(rollout: Rollout) -> dict[str, Any]:
    """What `llsrbm simulate --json` prints: SI units, radians; null for what there is not."""
    outcome = asdict(rollout.outcome)
    figures: dict[str, Any] = {
        **{name: outcome[name] for name in PROMISED},
        **outcome,
        "duration_s": rollout.duration,
        "scenario": asdict(rollout.scenario),
        "disturbance": asdict(rollout.disturbance),
        "events": [asdict(event) for event in diagnose(rollout)],
    }
    return {key: json_value(value) for key, value in figures.items()}


def detection_latency(rollout: Rollout) -> float | None:
    """From the simulator's first contact to its detection, s; None where one of them is missing."""
    true, detected = rollout.outcome.touchdown_true_s, rollout.outcome.touchdown_detected_s
    return None if true is None or detected is None else detected - true
