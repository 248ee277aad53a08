"""How a simulation ended: landed or fell, and by how much everything missed.

Strict success: it stands, nothing but feet touched, and nothing a hurdle, every flight before the
last ended on all feet that were to stand, every foot is within 50 mm of the plan, tilt ends below
2 deg and stayed below 15 deg after the last touchdown, it was not thrown up again for more than
30 ms, and the controller's program was solved in every tick; judged a second after the plan's end.
A body that turns over comes down with several rad/s and has to lean against its turn as it lands:
its tilt after touchdown counts from the planned attitude, at the end from the vertical as ever.

Recovered: strict success but for where the feet are, which a push or a new plan rightly moves.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from llsrbm.control.contact_schedule import Flight
from llsrbm.control.controller import WholeBodyController
from llsrbm.control.reference import com_at_rest
from llsrbm.mechanics import tilt, yaw
from llsrbm.motion.plan import Plan
from llsrbm.motion.replan import Replan
from llsrbm.motion.rollout import Outcome
from llsrbm.robots import Robot
from llsrbm.simulation.recorder import Recorder
from llsrbm.simulation.world import TickResult

Array = NDArray[np.float64]

FEET_WITHIN = 0.05  # m
FINAL_TILT = np.radians(2.0)
PEAK_TILT = np.radians(15.0)
SECOND_FLIGHT = 0.03  # s
TOPPLED = np.radians(60.0)  # from the planned attitude: beyond this no robot comes back
_LOW = 0.7  # of the planned height of the CoM above its feet: below this a robot sits, not stands
_LEANING = np.radians(15.0)
_AT_REST = 0.2  # s before the end in which a robot should stand still
_STILL = 0.1  # m/s of the CoM; a robot that stands sways at less
_SATURATED = 0.99  # of what a drive can give
_UPRIGHT = np.radians(45.0)  # tilt up to which a base has a heading
_UNDER_WAY = 0.3  # of the planned flight; contact before is a foot that leaves late


@dataclass(frozen=True)
class Fall:
    """When and how a robot fell."""

    time: float
    reason: str


def fallen(time: float, q: Array, planned: Array, result: TickResult) -> Fall | None:
    """Whether it has fallen in the state q (nq,), with its base planned to be at (3, 3)."""
    if result.trunk_contact:
        return Fall(time, "the trunk touched the ground")
    if result.obstacle_contact:
        return Fall(time, "it touched the hurdle")
    x, y, z, w = q[3:7].tolist()
    up = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    if up.dot(planned[:, 2]) < math.cos(TOPPLED):
        return Fall(time, "it toppled over")
    return None


def judge(
    robot: Robot,
    plan: Plan,
    recorder: Recorder,
    columns: dict[str, Any],
    controller: WholeBodyController,
    fall: Fall | None,
    wall_time: float,
    replans: Sequence[Replan] = (),
) -> Outcome:
    """Put a recorded simulation into figures.

    Args:
        robot, plan, recorder, controller: what took part.
        columns: the recorder's, with `time`, two ticks or more.
        fall: what the loop has seen, if it ended early.
        wall_time: of the whole loop, s.
        replans: made in it.
    """
    time, tick = columns["time"], float(columns["time"][1] - columns["time"][0])
    flights = controller.flights
    contacts = [_touchdowns(recorder, flight, flights[k + 1 :]) for k, flight in enumerate(flights)]
    reached = len(flights) == len(plan.schedule.flights)
    never: list[float | None] = [None] * len(robot.legs)
    first_contacts = contacts[-1] if reached else never
    touchdown = _first(first_contacts)
    detected = flights[-1].detected if reached else None
    tilts = tilt(columns["base_quat"])
    goal = plan.foot_position[-1]
    feet_off = np.linalg.norm((columns["foot_position"] - goal)[..., :2], axis=-1)
    com_off = columns["com"][-1] - com_at_rest(plan)
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
    takeoff = columns["phase"] < plan.schedule.flights[0]
    leans = _lean(columns) if plan.jump.turns else tilts
    peak_tilt = float(leans[after].max(initial=0.0))
    second_flight = float((after & ~contact.any(axis=1)).sum() * tick)
    trunk_touched = any(result.trunk_contact for result in recorder.results)
    foot_error = float(feet_off[-1].max())
    unsolved = sum(not entry.command.solved for entry in recorder.ticks)
    recovered = (
        fall is None
        and not trunk_touched
        and _rebounds_on_feet(plan, flights, contacts)
        and tilts[-1] < FINAL_TILT
        and peak_tilt < PEAK_TILT
        and second_flight < SECOND_FLIGHT
        and unsolved == 0
    )
    computing = [replan.computing_time for replan in replans]
    return Outcome(
        status="landed" if fall is None else "fell",
        reason="" if fall is None else fall.reason,
        fell_at_s=None if fall is None else fall.time,
        strict=bool(recovered and foot_error < FEET_WITHIN),
        final_yaw_error=_yaw_error(columns["base_quat"], -1, plan, -1),
        final_position_error=float(np.linalg.norm(com_off[:2])),
        final_tilt=float(tilts[-1]),
        final_speed=final_speed,
        touchdown_planned_s=flights[-1].touchdown if reached else plan.touchdown,
        touchdown_true_s=touchdown,
        touchdown_detected_s=detected,
        foot_touchdown_s=tuple(first_contacts),
        false_touchdowns=sum(map(_is_false, flights, contacts)),
        yaw_error_at_touchdown=_yaw_error_at_touchdown(plan, columns, touchdown),
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
        recovered=bool(recovered),
        replans=len(replans),
        replan_median_s=float(np.median(computing)) if computing else None,
        replan_p95_s=float(np.percentile(computing, 95)) if computing else None,
    )


def _touchdowns(recorder: Recorder, flight: Flight, later: list[Flight]) -> list[float | None]:
    """The first contact of each foot after a flight has begun, and before the next, s."""
    start, end = flight.lift_off, flight.touchdown
    first = np.array([result.first_contact for result in recorder.results])
    time = np.nan_to_num(first, nan=-1.0)
    first[time < start + _UNDER_WAY * (end - start)] = np.nan
    if later:
        first[time >= later[0].lift_off] = np.nan
    return [
        None if np.isnan(column).all() else round(float(np.nanmin(column)), 6) for column in first.T
    ]


def _first(contacts: list[float | None]) -> float | None:
    return min((time for time in contacts if time is not None), default=None)


def _is_false(flight: Flight, contacts: list[float | None]) -> bool:
    """Whether a flight's touchdown was detected before it came."""
    true = _first(contacts)
    return flight.detected is not None and (true is None or flight.detected < true)


def _rebounds_on_feet(
    plan: Plan, flights: list[Flight], contacts: list[list[float | None]]
) -> bool:
    """Whether each flight but the last ended on all feet that stand before the next."""
    schedule = plan.schedule
    for here, after, touched in zip(flights, flights[1:], contacts, strict=False):
        planned = np.any(schedule.stands[here.phase : after.phase], axis=0)
        if any(touched[foot] is None for foot in np.flatnonzero(planned)):
            return False
    return True


def _lean(columns: dict[str, Any]) -> Array:
    """(T,) rad: between the base's z axis and that of the attitude that was tracked."""
    actual, planned = (
        Rotation.from_quat(columns[name], scalar_first=True).apply([0.0, 0.0, 1.0])
        for name in ("base_quat", "reference_base_quat")
    )
    return np.arccos(np.clip(np.sum(actual * planned, axis=1), -1.0, 1.0))


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


def _yaw_error_at_touchdown(
    plan: Plan, columns: dict[str, Any], touchdown: float | None
) -> float | None:
    if touchdown is None:
        return None
    at = min(int(np.searchsorted(columns["time"], touchdown)), len(columns["time"]) - 1)
    knot = int(np.searchsorted(plan.time, plan.touchdown - 1e-9))
    return _yaw_error(columns["base_quat"], at, plan, knot)


def _yaw_error(quat: Array, at: int, plan: Plan, knot: int) -> float:
    """Of the base (T, 4) at a tick against the plan's knot, rad.

    A heading means nothing far from upright: there it is the vertical part of the turn from the
    planned attitude to the actual one.
    """
    actual, planned = quat[at], plan.base_quat[knot]
    if max(tilt(actual), tilt(planned)) > _UPRIGHT:
        turn = Rotation.from_quat(actual, scalar_first=True)
        turn = turn * Rotation.from_quat(planned, scalar_first=True).inv()
        return float(turn.as_rotvec()[2])
    return _wrapped(yaw(quat)[at] - yaw(plan.base_quat)[knot])


def _foot_error(time: Array, feet_off: Array, touchdowns: list[float | None]) -> float | None:
    errors = [
        float(feet_off[min(int(np.searchsorted(time, at)), len(time) - 1), foot])
        for foot, at in enumerate(touchdowns)
        if at is not None
    ]
    return max(errors, default=None)


def _wrapped(angle: Any) -> float:
    return float((angle + np.pi) % (2 * np.pi) - np.pi)
