"""What a plan, or the failure to find one, comes to in a row."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from llsrbm.errors import NotConverged
from llsrbm.sweep import rows as row

if TYPE_CHECKING:
    from llsrbm.motion.plan import Plan
    from llsrbm.robots.robot import Robot

# Share of the robot's weight below which a contact's force says nothing of friction.
_LOADED = 0.02
_LONGEST_MESSAGE = 500  # characters of a row's message


def solved(plan: Plan) -> dict[str, Any]:
    """What a solve took, whether it found a plan or not."""
    report = plan.report
    amounts = [violation.amount for violation in plan.violations.values()]
    return {
        "iterations": report.iterations,
        "attempts": report.attempts,
        "cost": report.cost,
        "solve_time_s": report.solve_time_s,
        "violation": max(amounts, default=None),
    }


def stopped(error: NotConverged, diagnosed: bool) -> dict[str, Any]:
    """What stops a jump: diagnosed, the limit; else the constraint that is violated most."""
    from llsrbm.planning.why.residuals import severity

    violations = error.plan.violations
    worst = max(violations, key=lambda name: severity(violations[name]), default=None)
    values: dict[str, Any] = {
        "status": row.NOT_PLANNED,
        "stopped_by": worst,
        "constraint": worst,
        "message": short(error),
        "violations": {name: violation.amount for name, violation in violations.items()},
    }
    if diagnosed and error.stops and error.stops[0].limit is not None:
        stop = error.stops[0]
        values |= {
            "stopped_by": stop.limit,
            "stop_limit": stop.limit,
            "stop_value": stop.value,
            "stop_needed": stop.needed,
        }
    return values


def figures(plan: Plan, robot: Robot) -> dict[str, Any]:
    """Durations, margins and loads of a plan."""
    from llsrbm.analysis.summary import peak_yaw_rate
    from llsrbm.body.peak_loads import planned_peak_load, planned_torque_shares
    from llsrbm.motion.rotation import final_yaw

    durations = np.diff(plan.phase_start)
    load = planned_peak_load(plan)
    flights = sum(durations[flight] for flight in plan.schedule.flights)
    values: dict[str, Any] = {
        "duration_s": plan.duration,
        "takeoff_s": plan.lift_off,
        "flight_s": float(flights),
        "landing_s": plan.duration - plan.touchdown,
        "lift_off_s": plan.lift_off,
        "touchdown_s": plan.touchdown,
        "phase_durations_s": durations.tolist(),
        "final_yaw": final_yaw(plan.time, plan.base_quat, plan.angular_velocity[:, 2]),
        "peak_yaw_rate": peak_yaw_rate(plan),
        "apex": float(plan.com[:, 2].max() - plan.com[0, 2]),
        "joint_torque_ratio": planned_torque_shares(plan),
    }
    if load is not None:
        values |= {
            "torque_share": load.ratio,
            "torque_joint": load.joint,
            "torque_phase": load.phase,
        }
    return values | _joints(plan, robot) | _forces(plan, robot)


def _joints(plan: Plan, robot: Robot) -> dict[str, Any]:
    """Largest speed and smallest margin at knots; between them would take a tenth of a plan."""
    q, model = plan.joint_position, robot.model
    room = np.minimum(q - model.lowerPositionLimit[7:], model.upperPositionLimit[7:] - q)
    tightest = int(room.min(axis=0).argmin())
    values: dict[str, Any] = {
        "joint_margin": float(room[:, tightest].min()),
        "margin_joint": plan.joint_names[tightest],
    }
    if plan.joint_velocity is not None:
        with np.errstate(divide="ignore", invalid="ignore"):  # joints without a speed limit
            shares = np.abs(plan.joint_velocity).max(axis=0) / robot.speed_limit
        fastest = int(shares.argmax())
        values |= {"speed_share": float(shares[fastest]), "speed_joint": plan.joint_names[fastest]}
    return values


def _forces(plan: Plan, robot: Robot) -> dict[str, Any]:
    """Forces at contacts, and how much of the friction they use."""
    from llsrbm.planning.problem.stage import GRAVITY

    force = plan.contact_force
    tangential = np.hypot(force[..., 0], force[..., 1])
    loaded = force[..., 2] > _LOADED * robot.mass * GRAVITY
    used = float((tangential[loaded] / force[..., 2][loaded]).max()) if loaded.any() else 0.0
    friction = plan.tuning.limits.get("friction", robot.file.limits.friction)
    return {
        "friction_share": used,
        "friction_margin": friction - used,
        "peak_force": float(np.linalg.norm(force, axis=-1).max()),
    }


def short(error: BaseException) -> str:
    """An error in one line of a row."""
    text = " ".join(str(error).split()) or type(error).__name__
    return text if len(text) <= _LONGEST_MESSAGE else f"{text[:_LONGEST_MESSAGE]}..."
