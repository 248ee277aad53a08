"""How a simulation ended: landed or fell, and by how much everything missed.

Strict success: it stands, nothing but feet touched, every foot is within 50 mm of the plan, tilt
ends below 2 deg and stayed below 15 deg after touchdown, it was not thrown up again for more than
30 ms, and the controller's program was solved in every tick; judged a second after the plan's end.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.control.controller import WholeBodyController
from llsrbm.motion.plan import Phase, Plan
from llsrbm.motion.rollout import Outcome
from llsrbm.motion.rotation import tilt, yaw
from llsrbm.robots import Robot
from llsrbm.simulation.recorder import Recorder

Array = NDArray[np.float64]

FEET_WITHIN = 0.05  # m
FINAL_TILT = np.radians(2.0)
PEAK_TILT = np.radians(15.0)
SECOND_FLIGHT = 0.03  # s
TOPPLED = np.radians(60.0)  # beyond this no robot comes back
_LOW = 0.7  # of the planned height of the CoM above its feet: below this a robot sits, not stands
_LEANING = np.radians(15.0)
_AT_REST = 0.2  # s before the end in which a robot should stand still
_STILL = 0.1  # m/s of the CoM; a robot that stands sways at less
_SATURATED = 0.99  # of what a drive can give
_UNDER_WAY = 0.3  # of the planned flight; contact before is a foot that leaves late


@dataclass(frozen=True)
class Fall:
    """When and how a robot fell."""

    time: float
    reason: str


def judge(
    robot: Robot,
    plan: Plan,
    recorder: Recorder,
    columns: dict[str, Any],
    controller: WholeBodyController,
    fall: Fall | None,
    wall_time: float,
) -> Outcome:
    """Put a recorded simulation into figures.

    Args:
        robot, plan, recorder, controller: what took part.
        columns: the recorder's, with `time`, two ticks or more.
        fall: what the loop has seen, if it ended early.
        wall_time: of the whole loop, s.
    """
    time, tick = columns["time"], float(columns["time"][1] - columns["time"][0])
    first_contacts = _touchdowns(plan, recorder)
    touched = [t for t in first_contacts if t is not None]
    touchdown = min(touched, default=None)
    detected = controller.detected_at
    tilts, headings = tilt(columns["base_quat"]), yaw(columns["base_quat"])
    goal = plan.foot_position[-1]
    feet_off = np.linalg.norm((columns["foot_position"] - goal)[..., :2], axis=-1)
    com_off = columns["com"][-1] - plan.com[-1]
    after = time >= touchdown if touchdown is not None else np.zeros(len(time), dtype=bool)
    contact = columns["contact"].astype(bool)
    height = float((columns["com"][-1] - columns["foot_position"][-1].mean(axis=0))[2])
    planned_height = float((plan.com[-1] - goal.mean(axis=0))[2])
    final_speed = float(
        np.linalg.norm(columns["linear_momentum"][time >= time[-1] - _AT_REST], axis=-1).max()
        / robot.mass
    )
    if fall is None:
        fall = _not_standing(
            float(time[-1]), touchdown, height / planned_height, float(tilts[-1]), final_speed
        )
    torque_share = np.abs(columns["torque"]) / np.maximum(columns["torque_limit"], 1e-9)
    speed = np.abs(np.array(recorder.v))[:, 6:]
    torque = np.abs([result.torque for result in recorder.results])
    takeoff = columns["phase"] == Phase.TAKEOFF
    peak_tilt = float(tilts[after].max(initial=0.0))
    second_flight = float((after & ~contact.any(axis=1)).sum() * tick)
    trunk_touched = any(result.trunk_contact for result in recorder.results)
    foot_error = float(feet_off[-1].max())
    unsolved = sum(not entry.command.solved for entry in recorder.ticks)
    strict = (
        fall is None
        and not trunk_touched
        and foot_error < FEET_WITHIN
        and tilts[-1] < FINAL_TILT
        and peak_tilt < PEAK_TILT
        and second_flight < SECOND_FLIGHT
        and unsolved == 0
    )
    return Outcome(
        status="landed" if fall is None else "fell",
        reason="" if fall is None else fall.reason,
        fell_at_s=None if fall is None else fall.time,
        strict=bool(strict),
        final_yaw_error=_wrapped(headings[-1] - yaw(plan.base_quat)[-1]),
        final_position_error=float(np.linalg.norm(com_off[:2])),
        final_tilt=float(tilts[-1]),
        final_speed=final_speed,
        touchdown_planned_s=float(plan.phase_start[2]),
        touchdown_true_s=touchdown,
        touchdown_detected_s=detected,
        foot_touchdown_s=tuple(first_contacts),
        false_touchdowns=int(detected is not None and (touchdown is None or detected < touchdown)),
        yaw_error_at_touchdown=_yaw_error(plan, time, headings, touchdown),
        foot_error_at_touchdown=_foot_error(time, feet_off, first_contacts),
        foot_error=foot_error,
        peak_tilt=peak_tilt,
        second_flight_s=second_flight,
        trunk_touched=trunk_touched,
        peak_torque_ratio=float((torque / robot.torque_limit).max()),
        peak_speed_ratio=float((speed / robot.speed_limit).max()),
        takeoff_joint_speed=float(speed[takeoff].max(initial=0.0)),
        saturated_fraction=float((torque_share >= _SATURATED).any(axis=1).mean()),
        unsolved_ticks=unsolved,
        tick_median_s=float(np.median(recorder.tick_times)),
        tick_p99_s=float(np.percentile(recorder.tick_times, 99)),
        real_time_factor=len(recorder) * tick / wall_time,
        control_rate_hz=1.0 / tick,
        landing_strategy=controller.landing,
    )


def _touchdowns(plan: Plan, recorder: Recorder) -> list[float | None]:
    """The first contact of each foot after the robot has left the ground, s."""
    start, end = plan.phase_start[1:3]
    first = np.array([result.first_contact for result in recorder.results])
    first[np.nan_to_num(first, nan=-1.0) < start + _UNDER_WAY * (end - start)] = np.nan
    return [
        None if np.isnan(column).all() else round(float(np.nanmin(column)), 6) for column in first.T
    ]


def _not_standing(
    end: float, touchdown: float | None, height: float, lean: float, speed: float
) -> Fall | None:
    if touchdown is None:
        return Fall(end, "it never touched the ground again")
    if height < _LOW:
        return Fall(end, f"it sits: the CoM is at {100 * height:.0f} % of its planned height")
    if lean > _LEANING:
        return Fall(end, f"it leans {np.degrees(lean):.0f} deg at the end")
    if speed > _STILL:
        return Fall(end, f"it still moves at {speed:.2f} m/s at the end")
    return None


def _yaw_error(plan: Plan, time: Array, heading: Array, touchdown: float | None) -> float | None:
    if touchdown is None:
        return None
    at = min(int(np.searchsorted(time, touchdown)), len(time) - 1)
    knot = int(np.searchsorted(plan.time, plan.phase_start[2] - 1e-9))
    return _wrapped(heading[at] - yaw(plan.base_quat)[knot])


def _foot_error(time: Array, feet_off: Array, touchdowns: list[float | None]) -> float | None:
    errors = [
        float(feet_off[min(int(np.searchsorted(time, at)), len(time) - 1), foot])
        for foot, at in enumerate(touchdowns)
        if at is not None
    ]
    return max(errors, default=None)


def _wrapped(angle: Any) -> float:
    return float((angle + np.pi) % (2 * np.pi) - np.pi)
