"""A design in one row of figures, to be compared with others.

A rollout alone has a plan's figures of the simulated whole body: its flight is that without any
contact, its forces hold impacts, and the time to solve it is not known.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.analysis.model_turn import model_turn
from llsrbm.analysis.summaries import planned_peak_load
from llsrbm.mechanics import GRAVITY, final_yaw, rotation_matrices
from llsrbm.motion.flights import flights, without_contact
from llsrbm.motion.outcome import Outcome
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.request.numbers import decimal

Array = NDArray[np.float64]


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
        solve_time_s=plan.report.solve_time_s,
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
    motion: Any, yaw_rate: Array, flight: NDArray[np.bool_], force: Array | None, mass: Any
) -> dict[str, Any]:
    """Figures of the first instants of a motion, as many as `yaw_rate` (K,) has."""
    until = slice(len(yaw_rate))
    com, quat = motion.com[until], motion.base_quat[until]
    feet_radius = smallest_Izz = None
    if flight.any():
        radius = np.linalg.norm(
            (motion.foot_position[until] - com[:, None])[flight][..., :2], axis=-1
        )
        feet_radius = float(radius.mean(axis=1).min())
        smallest_Izz = float(motion.inertia[until][flight, 2, 2].min())
    peak = None if force is None else float(np.linalg.norm(force, axis=-1).max())
    weighed = peak is not None and isinstance(mass, float | int)
    return {
        "apex": float(com[:, 2].max() - com[0, 2]),
        "final_yaw": final_yaw(motion.time[until], quat, yaw_rate),
        "peak_yaw_rate": float(np.abs(yaw_rate).max()),
        "feet_radius": feet_radius,
        "smallest_Izz": smallest_Izz,
        "peak_force": peak,
        "peak_force_in_weights": peak / (mass * GRAVITY) if weighed else None,
    }


@dataclass(frozen=True)
class Figure:
    """Title, unit and format of one of the figures."""

    name: str  # of `DesignFigures`
    title: str  # in words
    short: str  # the same where there is little room
    unit: str  # shown
    scale: float  # from SI to it
    decimals: int  # after the point
    # False where neither is: a short flight is not better than a long one.
    smaller_is_better: bool = False
    signed: bool = False  # whether it has a sign, and what is to be small is its size

    def value(self, figures: DesignFigures) -> float | None:
        """In SI units; None for what is not known or no number."""
        value = getattr(figures, self.name)
        return None if value is None or not math.isfinite(value) else float(value)

    def shown(self, figures: DesignFigures) -> str:
        """In the unit that is shown, without it."""
        value = self.value(figures)
        return "–" if value is None else self._text(value, signed=self.signed)

    def difference(self, figures: DesignFigures, other: DesignFigures) -> str:
        """By how much `figures` are more than `other`, with unit; "" where one is not known."""
        mine, theirs = self.value(figures), self.value(other)
        if mine is None or theirs is None:
            return ""
        return f"{self._text(mine - theirs, signed=True)} {self.unit}"

    def best(self, designs: Sequence[DesignFigures]) -> frozenset[int]:
        """Indices of the best designs, as shown; none where all are alike or it has no best."""
        sizes = {
            index: round(abs(value) * self.scale, self.decimals)
            for index, design in enumerate(designs)
            if design.valid and (value := self.value(design)) is not None
        }
        if not self.smaller_is_better or len(set(sizes.values())) < 2:
            return frozenset()
        smallest = min(sizes.values())
        return frozenset(index for index, size in sizes.items() if size == smallest)

    def _text(self, value: float, *, signed: bool) -> str:
        return decimal(value * self.scale, self.decimals, signed=signed)


_TURN: dict[str, Any] = {"unit": "°", "scale": math.degrees(1), "decimals": 1, "signed": True}

FIGURES = (
    Figure("duration_s", "Duration", "duration", "s", 1, 2),
    Figure("flight_time_s", "Flight time", "flight", "s", 1, 3),
    Figure("apex", "CoM rises", "apex", "m", 1, 3),
    Figure("final_yaw", "Yaw at the end", "yaw", "°", math.degrees(1), 1, signed=True),
    Figure("peak_yaw_rate", "Peak yaw rate", "yaw rate", "rad/s", 1, 2),
    Figure("feet_radius", "Feet radius", "feet", "m", 1, 3),
    Figure("smallest_Izz", "Least Izz", "Izz", "kg m²", 1, 2),
    Figure("peak_force", "Peak force", "force", "N", 1, 0, smaller_is_better=True),
    Figure("peak_force_in_weights", "Peak force", "force", "weights", 1, 2, smaller_is_better=True),
    Figure(
        "planned_torque_ratio", "Planned torque", "planned", "%", 100, 0, smaller_is_better=True
    ),
    Figure("peak_torque_ratio", "Peak torque", "torque", "%", 100, 0, smaller_is_better=True),
    Figure("model_turn_in_flight", "Model's turn error", "model", **_TURN, smaller_is_better=True),
    Figure("yaw_error_in_flight", "Turn in flight", "in flight", **_TURN, smaller_is_better=True),
    Figure("yaw_error_at_lift_off", "Yaw at lift-off", "lift-off", **_TURN),
    # Not the smaller the better: of a poor model the errors before and in flight cancel.
    Figure("yaw_error_at_touchdown", "Yaw at contact", "yaw error", **_TURN),
    Figure("solve_time_s", "Solve time", "solve", "ms", 1e3, 0, smaller_is_better=True),
)
"""The row, in its order, after the status."""


def _flight(rollout: Rollout) -> tuple[float | None, NDArray[np.bool_]]:
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


def _longest_flight(motion: WholeBodyMotion) -> tuple[float | None, NDArray[np.bool_]]:
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
