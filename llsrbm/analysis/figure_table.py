"""Title, unit and precision of every figure that is shown, wherever it is shown."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from llsrbm.analysis.figures import DesignFigures
from llsrbm.motion.outcome import Outcome
from llsrbm.number_text import decimal

UNKNOWN = "–"


@dataclass(frozen=True)
class Figure:
    """One figure of `DesignFigures`, of `Outcome`, or of both."""

    name: str  # of the attribute that holds it, in SI units
    title: str  # in words
    short: str  # the same where there is little room
    unit: str  # shown
    scale: float  # from SI to it
    decimals: int  # after the point
    # False where neither is: a short flight is not better than a long one.
    smaller_is_better: bool = False
    signed: bool = False  # whether it has a sign, and what is to be small is its size

    def value(self, figures: DesignFigures | Outcome) -> float | None:
        """In SI units; None for what is not known or no number."""
        value = getattr(figures, self.name)
        return None if value is None or not math.isfinite(value) else float(value)

    def shown(self, figures: DesignFigures | Outcome) -> str:
        """In the unit that is shown, without it."""
        value = self.value(figures)
        return UNKNOWN if value is None else self._text(value, signed=self.signed)

    def words(self, figures: DesignFigures | Outcome) -> str:
        """In the unit that is shown, with it."""
        shown = self.shown(figures)
        return shown if shown == UNKNOWN else f"{shown}{self._space}{self.unit}"

    def difference(self, figures: DesignFigures, other: DesignFigures) -> str:
        """Excess of `figures` over `other`, with unit; "" where one is not known."""
        mine, theirs = self.value(figures), self.value(other)
        if mine is None or theirs is None:
            return ""
        return f"{self._text(mine - theirs, signed=True)}{self._space}{self.unit}"

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

    @property
    def _space(self) -> str:
        return "" if self.unit == "°" else " "

    def _text(self, value: float, *, signed: bool) -> str:
        return decimal(value * self.scale, self.decimals, signed=signed)


_TURN: dict[str, Any] = {"unit": "°", "scale": math.degrees(1), "decimals": 1, "signed": True}
_TILT = ("°", math.degrees(1), 1)
_LOAD = ("%", 100, 0)

FIGURES = (
    Figure("duration_s", "Duration", "duration", "s", 1, 2),
    Figure("flight_time_s", "Flight time", "flight", "s", 1, 3),
    Figure("apex", "Apex", "apex", "cm", 100, 1),
    Figure("final_yaw", "Yaw at the end", "yaw", **_TURN),
    Figure("peak_yaw_rate", "Peak yaw rate", "yaw rate", "rad/s", 1, 2),
    Figure("feet_radius", "Feet radius", "feet", "m", 1, 3),
    Figure("smallest_Izz", "Least yaw inertia Izz", "Izz", "kg m²", 1, 2),
    Figure("Izz_change", "Yaw inertia Izz, flight", "Izz", "%", 100, 0, signed=True),
    Figure("peak_force", "Peak foot force", "force", "N", 1, 0, smaller_is_better=True),
    Figure(
        *("peak_force_in_weights", "Peak foot force", "force", "weights", 1, 2),
        smaller_is_better=True,
    ),
    Figure("planned_torque_ratio", "Planned torque", "planned", *_LOAD, smaller_is_better=True),
    Figure("peak_torque_ratio", "Peak torque", "torque", *_LOAD, smaller_is_better=True),
    Figure("model_turn_in_flight", "Model's turn error", "model", **_TURN, smaller_is_better=True),
    Figure("yaw_error_in_flight", "Turn in flight", "in flight", **_TURN, smaller_is_better=True),
    Figure("yaw_error_at_lift_off", "Yaw at lift-off", "lift-off", **_TURN),
    # Not the smaller the better: of a poor model the errors before and in flight cancel.
    Figure("yaw_error_at_touchdown", "Yaw at contact", "yaw error", **_TURN),
    Figure("solve_time_s", "Solve time", "solve", "ms", 1e3, 0, smaller_is_better=True),
)
"""The row by which designs are compared, in its order, after the status."""

_OF_OUTCOMES = (
    Figure("final_yaw_error", "Yaw error", "yaw error", **_TURN),
    Figure("final_tilt", "Tilt", "tilt", *_TILT),
    Figure("peak_tilt", "Peak tilt", "peak tilt", *_TILT),
    Figure("final_position_error", "CoM error", "CoM", "mm", 1e3, 0),
    Figure("foot_error", "Foot error", "feet", "mm", 1e3, 0),
    Figure("foot_error_at_touchdown", "Foot error at touchdown", "feet", "mm", 1e3, 0),
    Figure("second_flight_s", "Second flight", "bounce", "ms", 1e3, 0),
    Figure("peak_speed_ratio", "Peak speed", "speed", *_LOAD),
    Figure("saturated_fraction", "Saturated ticks", "saturated", "%", 100, 1),
    Figure("touchdown_planned_s", "Planned touchdown", "planned", "s", 1, 3),
    Figure("touchdown_true_s", "True touchdown", "true", "s", 1, 3),
    Figure("touchdown_detected_s", "Detected touchdown", "detected", "s", 1, 3),
    Figure("tick_median_s", "Controller tick", "tick", "ms", 1e3, 2),
    Figure("tick_p99_s", "Controller tick, p99", "p99", "ms", 1e3, 2),
    Figure("real_time_factor", "Real-time factor", "speed", "x real time", 1, 1),
    Figure("control_rate_hz", "Control rate", "rate", "Hz", 1, 0),
    Figure("replan_median_s", "Time of a new plan", "new plan", "ms", 1e3, 1),
    Figure("replan_p95_s", "Time of a new plan, p95", "p95", "ms", 1e3, 1),
)

FIGURE = {figure.name: figure for figure in (*FIGURES, *_OF_OUTCOMES)}
"""Every figure by its name."""
