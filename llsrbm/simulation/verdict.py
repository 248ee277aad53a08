"""The outcome of a simulation: landed or fell, with its errors.

Strict success: it stands, nothing but feet touched anything, no two links touched each other, and
nothing a hurdle, every flight before the last ended on all feet that were to stand, every foot is
within 50 mm of the plan horizontally, tilt ends below 2 deg and stayed below 15 deg after the last
touchdown, it was not thrown up again for more than 30 ms, and the controller's program was solved
in every tick; judged a second after the plan's end. A body that turns over comes down with several
rad/s and has to lean against its turn as it lands: its tilt after touchdown counts from the planned
attitude of that instant. That of others, and that at the end, counts from how the plan ends, level
or as its slope is.

Recovered: strict success but for where the feet are, which a push or a new plan rightly moves.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from llsrbm.arrays import Array
from llsrbm.control.contact_schedule import Flight
from llsrbm.control.controller import WholeBodyController
from llsrbm.control.reference import com_at_rest
from llsrbm.mechanics import turned
from llsrbm.motion.outcome import (
    FEET_WITHIN,
    FINAL_TILT,
    PEAK_TILT,
    SATURATED,
    SECOND_FLIGHT,
    Outcome,
)
from llsrbm.motion.plan import Plan
from llsrbm.motion.replan import Replan
from llsrbm.robots import Robot
from llsrbm.simulation.contacts import Touch
from llsrbm.simulation.episode import Fall, Recorder

# The thresholds of a fall; those of strict success are in `llsrbm.motion.outcome`.
_LOW = 0.7  # of the planned height of the CoM above its feet: below this a robot sits, not stands
_LEANING = np.radians(15.0)
_AT_REST = 0.2  # s before the end in which a robot should stand still
_STILL = 0.1  # m/s of the CoM; a robot that stands sways at less
_UNDER_WAY = 0.3  # of the planned flight; contact before is a foot that leaves late


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

    `columns`: the recorder's, with `time`, two ticks or more; `fall`: what the loop has seen, if it
    ended early; `wall_time`: of the whole loop, s; `replans`: made in it.
    """
    tick = float(columns["time"][1] - columns["time"][0])
    landing = _Landing.of(plan, recorder, controller.flights)
    at_end = _at_end(plan, columns, recorder.mass)
    after = _after_touchdown(plan, columns, landing.time, tick)
    fall = fall or _not_standing(plan, columns, landing.time, at_end)
    unsolved = sum(not entry.command.solved for entry in recorder.ticks)
    touched = _touched(recorder)
    recovered = bool(
        fall is None
        and not touched
        and landing.rebounded_on_feet
        and at_end["final_tilt"] < FINAL_TILT
        and after["peak_tilt"] < PEAK_TILT
        and after["second_flight_s"] < SECOND_FLIGHT
        and unsolved == 0
    )
    computing = [replan.computing_time for replan in replans]
    return Outcome(
        status="landed" if fall is None else "fell",
        reason="" if fall is None else fall.reason,
        fell_at_s=None if fall is None else fall.time,
        strict=recovered and at_end["foot_error"] < FEET_WITHIN,
        recovered=recovered,
        **at_end,
        **after,
        **_at_touchdown(plan, columns, landing),
        **_of_drives(robot, plan, recorder, columns),
        trunk_touched=any(result.trunk_contact for result in recorder.results),
        touched=touched,
        unsolved_ticks=unsolved,
        tick_median_s=float(np.median(recorder.tick_times)),
        tick_p99_s=float(np.percentile(recorder.tick_times, 99)),
        real_time_factor=len(recorder) * tick / wall_time,
        control_rate_hz=1.0 / tick,
        landing_strategy=controller.landing,
        replans=len(replans),
        replan_median_s=float(np.median(computing)) if computing else None,
        replan_p95_s=float(np.percentile(computing, 95)) if computing else None,
    )


def _touched(recorder: Recorder) -> str:
    """Which links but the feet touched what, and when first; "" if none did."""
    first: dict[Touch, float] = {}
    for result in recorder.results:
        for touch, time in result.touches:
            first.setdefault(touch, time)
    return "; ".join(
        f"{touch.link} touched {touch.other} at {time:.2f} s" for touch, time in first.items()
    )


@dataclass(frozen=True)
class _Landing:
    feet: list[float | None]  # s, the first contact of each foot after the last flight
    time: float | None  # the earliest
    lift_off: float | None  # s, of the last flight; None where it was not reached
    planned: float  # s, of the last flight
    detected: float | None  # s, of the last flight
    false: int  # how many flights' touchdowns were detected before they came
    # Whether each flight but the last ended on all feet that stand before the next.
    rebounded_on_feet: bool

    @classmethod
    def of(cls, plan: Plan, recorder: Recorder, flights: list[Flight]) -> _Landing:
        """Landing after flights, in order; the last planned one may not have been reached."""
        contacts = [
            _touchdowns(recorder, flight, flights[k + 1 :]) for k, flight in enumerate(flights)
        ]
        reached = len(flights) == len(plan.schedule.flights)
        never: list[float | None] = [None] * plan.foot_position.shape[1]
        feet = contacts[-1] if reached else never
        return cls(
            feet=feet,
            time=_first(feet),
            lift_off=flights[-1].lift_off if reached else None,
            planned=flights[-1].touchdown if reached else plan.touchdown,
            detected=flights[-1].detected if reached else None,
            false=sum(map(_is_false, flights, contacts)),
            rebounded_on_feet=_rebounds_on_feet(plan, flights, contacts),
        )


def _at_end(plan: Plan, columns: dict[str, Any], mass: float) -> dict[str, Any]:
    time, momentum = columns["time"], columns["linear_momentum"]
    com_off = columns["com"][-1] - com_at_rest(plan)
    resting = momentum[time >= time[-1] - _AT_REST]
    return {
        "final_yaw_error": float(turned(columns["base_quat"][-1:], plan.base_quat[-1:])[0]),
        "final_position_error": float(np.linalg.norm(com_off[:2])),
        "final_tilt": float(_lean(columns["base_quat"][-1:], plan.base_quat[-1:])[0]),
        "final_speed": float(np.linalg.norm(resting, axis=-1).max() / mass),
        "foot_error": float(_feet_off(plan, columns)[-1].max()),
    }


def _feet_off(plan: Plan, columns: dict[str, Any]) -> Array:
    """(T, L) m: horizontal distance of each foot from where the plan ends."""
    off = columns["foot_position"] - plan.foot_position[-1]
    return np.asarray(np.linalg.norm(off[..., :2], axis=-1))


def _after_touchdown(
    plan: Plan, columns: dict[str, Any], touchdown: float | None, tick: float
) -> dict[str, Any]:
    if touchdown is None:
        return {"peak_tilt": 0.0, "second_flight_s": 0.0}
    after = columns["time"] >= touchdown
    planned = columns["reference_base_quat"] if plan.jump.turns else plan.base_quat[-1:]
    leans = _lean(columns["base_quat"], planned)
    aloft = ~columns["contact"].astype(bool).any(axis=1)
    return {
        "peak_tilt": float(leans[after].max(initial=0.0)),
        "second_flight_s": float((after & aloft).sum() * tick),
    }


def _at_touchdown(plan: Plan, columns: dict[str, Any], landing: _Landing) -> dict[str, Any]:
    time = columns["time"]

    def index(instant: float) -> int:
        return min(int(np.searchsorted(time, instant)), len(time) - 1)

    knot = int(np.searchsorted(plan.time, plan.touchdown - 1e-9))

    def yaw_error(instant: float | None) -> float | None:
        if instant is None:
            return None
        quat = columns["base_quat"][[index(instant)]]
        return float(turned(quat, plan.base_quat[[knot]])[0])

    off = _feet_off(plan, columns)
    missed = [float(off[index(at), foot]) for foot, at in enumerate(landing.feet) if at is not None]
    return {
        "touchdown_planned_s": landing.planned,
        "touchdown_true_s": landing.time,
        "touchdown_detected_s": landing.detected,
        "foot_touchdown_s": tuple(landing.feet),
        "false_touchdowns": landing.false,
        "yaw_error_at_touchdown": yaw_error(landing.time),
        "yaw_error_at_planned_touchdown": (
            None
            if landing.lift_off is None or time[-1] < landing.planned
            else yaw_error(landing.planned)
        ),
        **_turning(columns, landing),
        "foot_error_at_touchdown": max(missed, default=None),
    }


def _turning(columns: dict[str, Any], landing: _Landing) -> dict[str, Any]:
    """How far the base was from the yaw that was tracked, at lift-off and by the flight."""
    time, until = columns["time"], min(landing.planned, landing.time or math.inf)
    if landing.lift_off is None or time[-1] < until:
        return {}
    first, last = np.searchsorted(time, [landing.lift_off - 1e-9, until - 1e-9])
    at = [first, max(first, last - 1)]  # before there is ground, or a reference that stands still
    lift_off, end = turned(columns["base_quat"][at], columns["reference_base_quat"][at])
    return {"yaw_error_at_lift_off": float(lift_off), "yaw_error_in_flight": float(end - lift_off)}


def _of_drives(
    robot: Robot, plan: Plan, recorder: Recorder, columns: dict[str, Any]
) -> dict[str, Any]:
    share = np.abs(columns["torque"]) / np.maximum(columns["torque_limit"], 1e-9)
    speed = np.abs(np.array(recorder.v))[:, 6:]
    torque = np.abs([result.torque for result in recorder.results])
    takeoff = columns["phase"] < plan.schedule.flights[0]
    return {
        "peak_torque_ratio": float((torque / robot.torque_limit).max()),
        "peak_speed_ratio": float((speed / robot.speed_limit).max()),
        "takeoff_joint_speed": float(speed[takeoff].max(initial=0.0)),
        "saturated_fraction": float((share >= SATURATED).any(axis=1).mean()),
    }


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
    """True if a flight's touchdown was detected before it came."""
    true = _first(contacts)
    return flight.detected is not None and (true is None or flight.detected < true)


def _rebounds_on_feet(
    plan: Plan, flights: list[Flight], contacts: list[list[float | None]]
) -> bool:
    """True if each flight but the last ended on all feet that stand before the next."""
    schedule = plan.schedule
    for here, after, touched in zip(flights, flights[1:], contacts, strict=False):
        planned = np.any(schedule.stands[here.phase : after.phase], axis=0)
        if any(touched[foot] is None for foot in np.flatnonzero(planned)):
            return False
    return True


def _lean(actual: Array, planned: Array) -> Array:
    """(T,) rad: between z axes of attitudes (T, 4) and of planned ones, (T, 4) or (1, 4)."""
    up, wanted = (
        Rotation.from_quat(quat, scalar_first=True).apply([0.0, 0.0, 1.0])
        for quat in (actual, planned)
    )
    # The half angle's sine is exact where the cosine of a small angle has lost its digits.
    half: Array = np.linalg.norm(up - wanted, axis=1) / 2
    return 2 * np.arcsin(np.minimum(half, 1.0))


def _not_standing(
    plan: Plan, columns: dict[str, Any], touchdown: float | None, at_end: dict[str, Any]
) -> Fall | None:
    end = float(columns["time"][-1])
    height = float((columns["com"][-1] - columns["foot_position"][-1].mean(axis=0))[2])
    height /= float((plan.com[-1] - plan.foot_position[-1].mean(axis=0))[2])
    if touchdown is None:
        return Fall(end, "it never touched the ground again")
    if height < _LOW:
        return Fall(
            end, f"it does not stand up: the CoM is at {100 * height:.0f} % of its planned height"
        )
    if at_end["final_tilt"] > _LEANING:
        return Fall(end, f"it leans {np.degrees(at_end['final_tilt']):.0f}° at the end")
    if at_end["final_speed"] > _STILL:
        return Fall(end, f"it still moves at {at_end['final_speed']:.2f} m/s at the end")
    return None
