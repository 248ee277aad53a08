"""A design in one row of figures, to be compared with others.

A rollout alone has a plan's figures of the simulated whole body: its flight is that without any
contact, its forces hold impacts, and the time to solve it is not known.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from llsrbm.analysis.model_turn import model_turn
from llsrbm.analysis.summaries import planned_peak_load
from llsrbm.arrays import Array, BoolArray
from llsrbm.mechanics import GRAVITY, final_yaw, rotation_matrices
from llsrbm.motion.flights import flights, without_contact
from llsrbm.motion.outcome import Outcome
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.whole_body import WholeBodyMotion


@dataclass(frozen=True)
class DesignFigures:
    """One row; None for what is not known."""

    # "planned" or "not converged"; with a simulation "landed" or "fell"; "motion" of one that is
    # neither.
    status: str
    duration_s: float  # s, with all that a simulation stands at its end
    flight_time_s: float | None  # s without any foot on the ground, of all flights together
    apex: float  # of the CoM above where it starts, m
    final_yaw: float  # of the base at the end, whole turns counted, rad
    peak_yaw_rate: float  # largest |angular velocity about z| of the base, rad/s
    # The feet's mean horizontal distance from the CoM, where it is smallest in flight, m.
    feet_radius: float | None
    smallest_Izz: float | None  # of the centroidal inertia about the vertical, in flight, kg m2
    peak_force: float | None  # largest contact force on one foot, N
    peak_force_in_weights: float | None  # the same in robots' weights
    # Largest share of the torque available at a joint's speed, in the plan.
    planned_torque_ratio: float | None = None
    peak_torque_ratio: float | None = None  # largest share of a torque limit, in the simulation
    # Of the base at its first contact, against the plan at its own, rad.
    yaw_error_at_touchdown: float | None = None
    solve_time_s: float | None = None  # wall time inside the solver, s
    # By how much the whole body turns in flight beyond the plan for what its model leaves out, rad
    # (`llsrbm.analysis.model_turn`); yaw_error_in_flight: by how much the simulated one did.
    model_turn_in_flight: float | None = None
    yaw_error_at_lift_off: float | None = None  # of the base against the plan, simulated, rad
    yaw_error_in_flight: float | None = None
    # The mean Izz in flight beyond that at the start, as a share of it.
    Izz_change: float | None = None

    @property
    def valid(self) -> bool:
        """True if the jump could be made, as far as is known."""
        return self.status in ("planned", "landed")


def figures_of_plan(plan: Plan, rollout: Rollout | None = None) -> DesignFigures:
    """A plan's figures, with those of a simulation that followed it."""
    feet = plan.foot_position.shape[1]
    outcome = None if rollout is None else rollout.outcome
    load = planned_peak_load(plan)
    status = "planned" if plan.solved else "not converged"
    error = model_turn(plan)
    return DesignFigures(
        status=status if outcome is None else outcome.status,
        duration_s=plan.duration,
        flight_time_s=float(np.diff(plan.phase_start)[list(plan.schedule.flights)].sum()),
        **_moving(
            plan,
            plan.angular_velocity[:, 2],
            np.asarray(~plan.contact.any(axis=1)),
            # Of a sole's corners, the sum.
            plan.contact_force.reshape(len(plan.time), feet, -1, 3).sum(axis=2),
            plan.base_mass + float(plan.leg_mass.sum()),
        ),
        planned_torque_ratio=None if load is None else load.ratio,
        peak_torque_ratio=None if outcome is None else outcome.peak_torque_ratio,
        model_turn_in_flight=None if error is None else error.flight,
        **_turning(outcome),
        solve_time_s=plan.effort.solve_time_s,
    )


def figures_of_rollout(rollout: Rollout) -> DesignFigures:
    """A rollout's own figures, until it fell if it did."""
    outcome = rollout.outcome
    end = math.inf if outcome.fell_at_s is None else outcome.fell_at_s
    count = max(1, int(np.searchsorted(rollout.time, end, side="right")))
    flight_time, flight = _flight(rollout)
    up = rotation_matrices(rollout.base_quat[:count])[:, 2]  # the world's z in the base's axes
    yaw_rate = (up * rollout.qvel[:count, 3:6]).sum(axis=1)
    mass = rollout.robot_parameters.get("mass")
    return DesignFigures(
        status=outcome.status,
        duration_s=rollout.duration,
        flight_time_s=flight_time,
        **_moving(rollout, yaw_rate, flight[:count], rollout.contact_force[:count], mass),
        peak_torque_ratio=outcome.peak_torque_ratio,
        **_turning(outcome),
    )


def _turning(outcome: Outcome | None) -> dict[str, Any]:
    names = ("yaw_error_at_lift_off", "yaw_error_in_flight", "yaw_error_at_touchdown")
    return {} if outcome is None else {name: getattr(outcome, name) for name in names}


def figures_of_motion(motion: WholeBodyMotion) -> DesignFigures:
    """The figures that follow from a motion itself; its flight is the longest time in the air."""
    flight_time, flight = _longest_flight(motion)
    yaw_rate = motion.angular_velocity[:, 2]
    return DesignFigures(
        status="motion",
        duration_s=float(motion.time[-1] - motion.time[0]),
        flight_time_s=flight_time,
        **_moving(motion, yaw_rate, flight, motion.foot_force, motion.robot.mass),
    )


def _moving(
    motion: Any, yaw_rate: Array, flight: BoolArray, force: Array | None, mass: Any
) -> dict[str, Any]:
    """Figures of the first instants of a motion, as many as `yaw_rate` (K,) has."""
    until = slice(len(yaw_rate))
    com, quat = motion.com[until], motion.base_quat[until]
    feet_radius = smallest_Izz = change = None
    if flight.any():
        radius = np.linalg.norm(
            (motion.foot_position[until] - com[:, None])[flight][..., :2], axis=-1
        )
        feet_radius = float(radius.mean(axis=1).min())
        in_flight = motion.inertia[until][flight, 2, 2]
        smallest_Izz = float(in_flight.min())
        change = float(in_flight.mean() / motion.inertia[0, 2, 2]) - 1
    peak = None if force is None else float(np.linalg.norm(force, axis=-1).max())
    weighed = peak is not None and isinstance(mass, float | int)
    return {
        "apex": float(com[:, 2].max() - com[0, 2]),
        "final_yaw": final_yaw(motion.time[until], quat, yaw_rate),
        "peak_yaw_rate": float(np.abs(yaw_rate).max()),
        "feet_radius": feet_radius,
        "smallest_Izz": smallest_Izz,
        "Izz_change": change,
        "peak_force": peak,
        "peak_force_in_weights": peak / (mass * GRAVITY) if weighed else None,
    }


def _flight(rollout: Rollout) -> tuple[float | None, BoolArray]:
    """From when the last foot has left until the first comes back: how long, s, and (T,) when.

    Without the touchdowns, which have to be known for the length, it is while the controller flies.
    """
    planned = rollout.schedule.flights
    flown = flights(rollout)
    durations = [flight.duration for flight in flown if flight.duration is not None]
    if len(durations) < len(planned):
        aloft = ~rollout.contact.astype(bool).any(axis=1)
        return None, np.isin(rollout.phase, planned) & aloft
    return sum(durations), np.any([without_contact(rollout, flight) for flight in flown], axis=0)


def _longest_flight(motion: WholeBodyMotion) -> tuple[float | None, BoolArray]:
    """Length (s) and instants (K,) of the longest flight; None without one that ends."""
    standing = np.flatnonzero(motion.contact.any(axis=1))
    apart = np.diff(motion.time[standing])
    jumps = np.diff(standing) > 1
    flight = np.zeros(len(motion.time), dtype=bool)
    if not jumps.any():
        return None, flight
    longest = int(np.argmax(np.where(jumps, apart, 0.0)))
    flight[standing[longest] + 1 : standing[longest + 1]] = True
    # It begins after the last instant with a contact.
    first = standing[longest] + 1
    return float(motion.time[standing[longest + 1]] - motion.time[first]), flight
