"""Power of the drives: what they give and take back, what of it the battery gives, what heats them.

    P_j = tau_j q'_j,    battery: sum over j of P_j + R_j (tau_j / k_j)^2,

with the drive's torque tau, which moves its rotor and its friction too, the joint's speed q', the
torque constant k at the joint and the winding's resistance R.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
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
    heat_j: dict[str, float] | None = None

    def as_dict(self) -> dict[str, Any]:
        """Plain data; null for what is not known or not finite."""
        return {key: json_value(value) for key, value in asdict(self).items()}


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

    def find(self, motion: SampledMotion) -> Finding:
        """The drive that takes back most."""
        limit = motion.robot.file.limits.regeneration
        if limit is None:
            return self.nothing("the robot's file has no limits.regeneration")
        power = DrivePower.of(motion)
        if power is None:
            return self.unknown(NO_TORQUES)
        shares = np.maximum(-power.mechanical, 0.0) / limit
        return self.largest(motion, shares, limit, power.names)


class _PowerCut(Check):
    """A limit beyond which the robot cuts its power; `time_s` is then the first instant beyond."""

    def cut(
        self, motion: SampledMotion, shares: Array, limits: ArrayLike, names: Sequence[str]
    ) -> Finding:
        """The largest of `shares` (K, n) of `limits` (n,)."""
        found = self.largest(motion, shares, limits, tuple(names))
        if found.holds:
            return found
        beyond = ~(shares <= 1 + ALLOWANCE).all(axis=1)
        return replace(found, time_s=float(motion.time[beyond.argmax()]), why=CUT)


class BatteryCurrent(_PowerCut):
    """The battery gives and takes back the currents that it can: worst = |I| / I_max."""

    name, unit = "battery_current", "A"

    def find(self, motion: SampledMotion) -> Finding:
        """The larger share, of what it gives or of what it takes back."""
        battery = motion.robot.file.drives.electrical
        most = (None, None) if battery is None else (battery.current, battery.charge_current)
        if most == (None, None):
            return self.nothing("the robot's file has no current of its battery")
        power = DrivePower.of(motion)
        if power is None or power.current is None:
            return self.unknown(NO_TORQUES)
        ways = zip((1.0, -1.0), most, ("battery gives", "battery takes back"), strict=True)
        signs, limits, names = zip(*(way for way in ways if way[1] is not None), strict=True)
        currents = np.maximum(np.outer(power.current, signs), 0.0)
        return self.cut(motion, currents / np.array(limits), limits, names)


class WindingHeat(_PowerCut):
    """Heat in each winding over the motion, all of which stays there: worst = Q / Q_max."""

    name, unit = "winding_heat", "J"

    def find(self, motion: SampledMotion) -> Finding:
        """The drive that comes nearest to its limit."""
        windings = Windings.of(motion.robot)
        if windings is None or np.isinf(windings.heat).all():
            return self.nothing("the robot's file has no heat of its windings")
        power = DrivePower.of(motion)
        if power is None or power.heat is None:
            return self.unknown(NO_TORQUES)
        return self.cut(motion, power.heat / windings.heat, windings.heat, power.names)
