"""Plans and rollouts in a few figures, for the command line, the page and scripts."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

import numpy as np

from llsrbm.analysis.diagnosis import diagnose
from llsrbm.body.peak_loads import PeakLoad, peak_load, torque_share
from llsrbm.mechanics import final_yaw
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.trajectory import json_value


def peak_yaw_rate(plan: Plan) -> float:
    """Largest |angular velocity about z| of the base, rad/s."""
    return float(np.abs(plan.angular_velocity[:, 2]).max())


def worst_violation(plan: Plan) -> str:
    """One line on the constraint that is violated most, each measured in its own SI unit."""
    if not plan.violations:
        return "none is known"
    name, worst = max(
        plan.violations.items(), key=lambda item: np.nan_to_num(item[1].amount, nan=math.inf)
    )
    return f"at most {worst.amount:.1e} {worst.unit} ({name}, {worst.phase}, {worst.time:.2f} s)"


_OF_REPORT = (
    *("status", "solver", "iterations", "guess"),
    *("solve_time_s", "total_time_s", "build_time_s", "cost"),
)


def plan_summary(plan: Plan) -> dict[str, Any]:
    """The output of `llsrbm plan --json`: SI units, radians; null for values that are no number."""
    figures: dict[str, Any] = {
        **{name: getattr(plan.report, name) for name in _OF_REPORT},
        "duration_s": plan.duration,
        "phase_durations_s": np.diff(plan.phase_start).tolist(),
        "peak_yaw_rate": peak_yaw_rate(plan),
        "final_yaw": final_yaw(plan.time, plan.base_quat, plan.angular_velocity[:, 2]),
        "violations": {name: v.amount for name, v in plan.violations.items()},
        "joint_torque_ratio": planned_torque_shares(plan),
        "phases": phases(plan),
        "request": plan.jump.as_dict(),
    }
    return {key: json_value(value) for key, value in figures.items()}


def phases(plan: Plan) -> list[dict[str, Any]]:
    """In order: `name`, `feet` (names of the legs that stand in it), `duration_s`."""
    return [
        {"name": phase.name, "feet": list(phase.feet), "duration_s": duration}
        for phase, duration in zip(plan.schedule, np.diff(plan.phase_start).tolist(), strict=True)
    ]


def planned_peak_load(plan: Plan) -> PeakLoad | None:
    """The most loaded joint of a plan; None if its torques are not known."""
    if plan.joint_torque is None or plan.joint_torque_limit is None:
        return None
    intervals = slice(0, -1)  # the last knot's are those of standing
    return peak_load(
        plan.joint_names,
        plan.time,
        plan.phase[intervals],
        plan.schedule,
        plan.joint_torque[intervals],
        plan.joint_torque_limit[intervals],
    )


def planned_torque_shares(plan: Plan) -> dict[str, float]:
    """Joint -> largest share of the torque available at its speed; empty if that is not known."""
    if plan.joint_torque is None or plan.joint_torque_limit is None:
        return {}
    largest = torque_share(plan.joint_torque, plan.joint_torque_limit).max(axis=0)
    return dict(zip(plan.joint_names, largest.tolist(), strict=True))


# Figures promised by the contract, in its order; further figures may follow.
PROMISED = (
    *("status", "final_yaw_error", "final_position_error", "final_tilt", "touchdown_true_s"),
    *("touchdown_detected_s", "false_touchdowns", "peak_torque_ratio", "peak_speed_ratio"),
    *("saturated_fraction", "tick_median_s", "tick_p99_s", "real_time_factor", "control_rate_hz"),
    *("strict", "unsolved_ticks", "recovered", "replans", "replan_median_s", "replan_p95_s"),
)


def rollout_summary(rollout: Rollout) -> dict[str, Any]:
    """The output of `llsrbm simulate --json`: SI units, radians; null for missing values."""
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
