"""Plans and rollouts in a few figures, for the command line, the page and scripts."""

from dataclasses import asdict
from typing import Any

import numpy as np

from llsrbm.analysis.diagnosis import diagnose
from llsrbm.analysis.model_turn import model_turn
from llsrbm.body.peak_loads import PeakLoad, peak_load, torque_share
from llsrbm.certificate import certified
from llsrbm.certificate.power import DrivePower, PowerForecast
from llsrbm.errors import InputError, NotConverged, RobotFileError, Stop
from llsrbm.mechanics import final_yaw
from llsrbm.motion.plan import Plan
from llsrbm.motion.robot import robot_of
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.trajectory import json_value
from llsrbm.robots.drives.windings import Windings


def peak_yaw_rate(plan: Plan) -> float:
    """Largest |angular velocity about z| of the base, rad/s."""
    return float(np.abs(plan.angular_velocity[:, 2]).max())


_FIRST = (
    *("status", "solver", "iterations", "guess"),
    *("solve_time_s", "total_time_s", "build_time_s", "cost", "compiling"),
)


def plan_summary(plan: Plan) -> dict[str, Any]:
    """The output of `llsrbm plan --json`: SI units, radians; null for values that are no number."""
    error = model_turn(plan)
    solves = {**asdict(plan.report), **asdict(plan.effort), "cost": plan.cost}
    figures: dict[str, Any] = {
        **{name: solves[name] for name in _FIRST},
        "duration_s": plan.duration,
        "phase_durations_s": np.diff(plan.phase_start).tolist(),
        "peak_yaw_rate": peak_yaw_rate(plan),
        "final_yaw": final_yaw(plan.time, plan.base_quat, plan.angular_velocity[:, 2]),
        "model_turn": None if error is None else asdict(error),
        "refined": plan.refined,
        "refinement": None if plan.refinement is None else asdict(plan.refinement),
        "violations": {name: v.amount for name, v in plan.violations.items()},
        "joint_torque_ratio": planned_torque_shares(plan),
        "power": power_forecast(plan).as_dict(),
        "phases": phases(plan),
        "request": plan.jump.as_dict(),
    }
    return {key: json_value(value) for key, value in figures.items()}


def certificate_summary(plan: Plan) -> dict[str, Any]:
    """Further output of `llsrbm plan --json`: `certificate` and `certified`, whether it holds.

    No certificate, null, is of a plan that failed, whose instants may run backwards, and where the
    robot is not there or has other joints by now.
    """
    plan = certified(plan)
    return {"certificate": json_value(plan.certificate), "certified": plan.certified}


def refusal_summary(error: NotConverged) -> dict[str, Any]:
    """Further output of `llsrbm plan --json` where a request is not feasible.

    `nearest`, the request's fields of the nearest jump, null if there is none; `limits`, the most
    important first, `value` what the request needs and `limit` what it may have.
    """
    nearest = None if error.nearest is None else error.nearest.jump.as_dict()
    return {"nearest": nearest, "limits": [_limit(stop) for stop in error.stops]}


def _limit(stop: Stop) -> dict[str, Any]:
    of, known = stop.demand, stop.amount > 0
    needed, has, unit = (
        (stop.needed, stop.value, stop.unit) if of is None else (of.needed, of.has, of.unit)
    )
    return {
        "name": stop.limit or stop.constraint,
        "joint": None if of is None else of.joint,
        "phase": stop.phase,
        "time_s": stop.time,
        "value": json_value(needed if known else None),
        "limit": json_value(has if stop.limit else None),
        "unit": unit,
    }


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


def power_forecast(trajectory: Plan | Rollout) -> PowerForecast:
    """Demands on drives and battery by the torques and speeds that a plan or rollout states."""
    if isinstance(trajectory, Rollout):
        torque, speed = trajectory.torque, trajectory.qvel[:, 6:]
    elif trajectory.joint_torque is None or trajectory.joint_velocity is None:
        return PowerForecast()
    else:
        torque, speed = trajectory.joint_torque, trajectory.joint_velocity
    # Both ends of each interval or tick, over which the torque stays.
    time = np.repeat(trajectory.time, 2)[1:-1]
    torque, speed = np.repeat(torque[:-1], 2, axis=0), np.repeat(speed, 2, axis=0)[1:-1]
    names = trajectory.joint_names
    with np.errstate(all="ignore"):  # those of a plan that failed may be anything
        return DrivePower(names, time, torque, speed, _windings(trajectory)).forecast()


def _windings(trajectory: Plan | Rollout) -> Windings | None:
    """Those of the trajectory's joints; None where the robot is not there, or is another by now."""
    try:
        robot = robot_of(trajectory)
    except (InputError, RobotFileError):
        return None
    if sorted(trajectory.joint_names) != sorted(robot.joint_names):
        return None
    windings = Windings.of(robot)
    order = [robot.joint_names.index(name) for name in trajectory.joint_names]
    return None if windings is None else windings.reordered(order)


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
        "power": power_forecast(rollout).as_dict(),
        "scenario": asdict(rollout.scenario),
        "disturbance": asdict(rollout.disturbance),
        "events": [asdict(event) for event in diagnose(rollout)],
    }
    return {key: json_value(value) for key, value in figures.items()}
