"""Power of the drives: what they give and take back, what of it the battery gives, what heats them.

    P_j = tau_j q'_j,    battery: sum over j of P_j + R_j (tau_j / k_j)^2,

with the drive's torque tau, which moves its rotor and its friction too, the joint's speed q', the
torque constant k at the joint and the winding's resistance R.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import cumulative_trapezoid

from llsrbm.arrays import Array
from llsrbm.certificate.finding import ALLOWANCE, Check, Finding
from llsrbm.certificate.sampled_motion import NO_TORQUES, SampledMotion
from llsrbm.motion.trajectory import json_value
from llsrbm.robots.drives.windings import Windings

CUT = "the robot will cut its power"


@dataclass(frozen=True)
class PowerForecast:
    """Demands of a motion on drives and battery; None for what is not known.

    Attributes:
        peak_w, peak_s: largest sum of what the drives give, W, and its instant, s; back_w, back_s:
            the same of what they take back, a positive number.
        energy_j, energy_back_j: J over the motion of either.
        electrical_peak_w: largest power from the battery, W; battery_current_a: its current, A.
        heat_j: joint -> heat in its winding over the motion, J.
    """

    peak_w: float | None = None
    peak_s: float | None = None
    back_w: float | None = None
    back_s: float | None = None
    energy_j: float | None = None
    energy_back_j: float | None = None
    electrical_peak_w: float | None = None
    battery_current_a: float | None = None
    heat_j: dict[str, float] | None = field(default=None, hash=False)

    def as_dict(self) -> dict[str, Any]:
        """Plain data; null for what is not known or not finite."""
        return {key: json_value(value) for key, value in asdict(self).items()}

    def then(self, later: PowerForecast) -> PowerForecast:
        """Those of a motion and of one that goes on from its last instant."""
        if self.peak_w is None or later.peak_w is None:
            return self if later.peak_w is None else later
        gives = max(self, later, key=lambda each: each.peak_w or 0.0)
        takes = max(self, later, key=lambda each: each.back_w or 0.0)
        heat, more = self.heat_j, later.heat_j
        return PowerForecast(
            *(gives.peak_w, gives.peak_s, takes.back_w, takes.back_s),
            energy_j=_of_both(operator.add, self.energy_j, later.energy_j),
            energy_back_j=_of_both(operator.add, self.energy_back_j, later.energy_back_j),
            electrical_peak_w=_of_both(max, self.electrical_peak_w, later.electrical_peak_w),
            battery_current_a=_of_both(max, self.battery_current_a, later.battery_current_a),
            heat_j=heat and more and {name: heat[name] + more[name] for name in heat},
        )


def _of_both(
    of: Callable[[float, float], float], one: float | None, other: float | None
) -> float | None:
    return None if one is None or other is None else of(one, other)


@dataclass(frozen=True, eq=False)
class DrivePower:
    """Torques and speeds of J joints at K instants, and what follows from them.

    Attributes:
        names: (J,) of the joints; time: (K,) s.
        torque, speed: (K, J) Nm or N of the drives, rad/s or m/s of the joints.
        windings: in the order of `names`; None: not known.
    """

    names: tuple[str, ...]
    time: Array
    torque: Array
    speed: Array
    windings: Windings | None

    @staticmethod
    def of(motion: SampledMotion) -> DrivePower | None:
        """Power of a motion at 1 kHz; None where torques are not known."""
        if motion.torque is None:
            return None
        robot = motion.robot
        return DrivePower(
            *(robot.joint_names, motion.time, motion.torque, motion.joint_velocity),
            windings=Windings.of(robot),
        )

    @cached_property
    def mechanical(self) -> Array:
        """(K, J) W that the drives give; negative: what they take back."""
        return self.torque * self.speed

    @cached_property
    def heat(self) -> Array | None:
        """(K, J) J in the windings until each instant."""
        if self.windings is None:
            return None
        heating = self.windings.heating(self.torque)
        return cumulative_trapezoid(heating, self.time, axis=0, initial=0.0)

    @cached_property
    def electrical(self) -> Array | None:
        """(K,) W from the battery; negative: what it takes back."""
        if self.windings is None:
            return None
        return (self.mechanical + self.windings.heating(self.torque)).sum(axis=1)

    @cached_property
    def current(self) -> Array | None:
        """(K,) A from the battery; None where its voltage is not known, too."""
        if self.windings is None or self.electrical is None:
            return None
        voltage = self.windings.battery.voltage
        return None if voltage is None else self.electrical / voltage

    def forecast(self) -> PowerForecast:
        """Peaks, energies and heat."""
        given = np.maximum(self.mechanical, 0.0).sum(axis=1)
        back = np.maximum(-self.mechanical, 0.0).sum(axis=1)
        heat = None if self.heat is None else self.heat[-1].tolist()
        return PowerForecast(
            peak_w=float(given.max()),
            peak_s=float(self.time[given.argmax()]),
            back_w=float(back.max()),
            back_s=float(self.time[back.argmax()]),
            energy_j=float(np.trapezoid(given, self.time)),
            energy_back_j=float(np.trapezoid(back, self.time)),
            electrical_peak_w=None if self.electrical is None else float(self.electrical.max()),
            battery_current_a=None if self.current is None else float(self.current.max()),
            heat_j=None if heat is None else dict(zip(self.names, heat, strict=True)),
        )


class Regeneration(Check):
    """Each drive takes back no more than its file's `limits.regeneration`: worst = -P / that."""

    name, unit = "regeneration", "W"

    def take(self, motion: SampledMotion) -> None:
        """The drive that takes back most."""
        limit = motion.robot.file.limits.regeneration
        if limit is None:
            self.nothing("the robot's file has no limits.regeneration")
            return
        power = DrivePower.of(motion)
        if power is None:
            self.unknown(NO_TORQUES)
            return
        shares = np.maximum(-power.mechanical, 0.0) / limit
        self.largest(motion, shares, limit, power.names)


class _PowerCut(Check):
    """A limit beyond which the robot cuts its power; `time_s` is then the first instant beyond."""

    def __init__(self) -> None:
        super().__init__()
        self._cut_s: float | None = None

    def cut(
        self, motion: SampledMotion, shares: Array, limits: ArrayLike, names: Sequence[str]
    ) -> None:
        """Find the largest of `shares` (K, n) of `limits` (n,), and the first beyond."""
        beyond = ~(shares <= 1 + ALLOWANCE).all(axis=1)
        if self._cut_s is None and beyond.any():
            self._cut_s = float(motion.time[beyond.argmax()])
        self.largest(motion, shares, limits, names)

    @property
    def finding(self) -> Finding:
        """The worst value of what was taken, at the instant at which the power is cut."""
        found = super().finding
        return found if found.holds is not False else replace(found, time_s=self._cut_s, why=CUT)


class BatteryCurrent(_PowerCut):
    """The battery gives and takes back the currents that it can: worst = |I| / I_max."""

    name, unit = "battery_current", "A"

    def take(self, motion: SampledMotion) -> None:
        """The larger share, of what it gives or of what it takes back."""
        battery = motion.robot.file.drives.electrical
        most = (None, None) if battery is None else (battery.current, battery.charge_current)
        if most == (None, None):
            self.nothing("the robot's file has no current of its battery")
            return
        power = DrivePower.of(motion)
        if power is None or power.current is None:
            self.unknown(NO_TORQUES)
            return
        ways = zip((1.0, -1.0), most, ("battery gives", "battery takes back"), strict=True)
        signs, limits, names = zip(*(way for way in ways if way[1] is not None), strict=True)
        currents = np.maximum(np.outer(power.current, signs), 0.0)
        self.cut(motion, currents / np.array(limits), limits, names)


class WindingHeat(_PowerCut):
    """Heat in each winding over the motion, all of which stays there: worst = Q / Q_max."""

    name, unit = "winding_heat", "J"

    def __init__(self) -> None:
        super().__init__()
        self._heat: Array | float = 0.0  # (J,) J so far

    def take(self, motion: SampledMotion) -> None:
        """The drive that comes nearest to its limit."""
        windings = Windings.of(motion.robot)
        if windings is None or np.isinf(windings.heat).all():
            self.nothing("the robot's file has no heat of its windings")
            return
        power = DrivePower.of(motion)
        if power is None or power.heat is None:
            self.unknown(NO_TORQUES)
            return
        heat = self._heat + power.heat
        self._heat = heat[-1]
        self.cut(motion, heat / windings.heat, windings.heat, power.names)
