"""Conditions under which a player stops by itself: each a small class that looks at every tick."""

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from llsrbm.arrays import Array
from llsrbm.control.motor_command import MotorCommand
from llsrbm.control.readings import Readings
from llsrbm.player.posture import Planned, up_of_quat
from llsrbm.player.tier import PERIOD
from llsrbm.robots import Robot
from llsrbm.robots.drives.torques import torque_range
from llsrbm.wire.link import Health

LINK_LOST = 0.02  # s without a reading: ten in a row
TILTED = np.radians(45.0)  # from the planned attitude; beyond it no landing is on the feet
# rad (m): a joint that far from the plan's, for so long, s, is not on its way there. Feet that land
# early or late are off by less.
MAX_TRACKING_ERROR, TRACKING_ERROR_FOR = 0.8, 0.03
# s by which readings are later than the first ones were, or commands are followed; for how long.
LATE, LATE_FOR = 0.01, 0.01
# s from a reading to its command: jumps through a wire of 6 instead of 2 ms go as well as others.
DEADLINE = 0.004
# Commands that missed it, of the last so many; and s in which the player itself did nothing.
MISSED, LAST_SENT, PAUSED = 10, 50, 0.02
# Share of a drive's torque by which it differs from every command under way, and for how long, s.
MAX_TORQUE_ERROR, TORQUE_ERROR_FOR = 0.08, 0.04
UNDER_WAY = 4  # commands: up to 6 ms
# Of motors, deg C, and of the battery's charge. Our own choice: a jump takes the most of both.
HOTTEST, LEAST_CHARGE = 75.0, 0.25


@dataclass(frozen=True, eq=False)
class Moment:
    """A tick as stop conditions see it, after its reading and before its command."""

    now: float  # s by the player's clock
    readings: Readings
    planned: Planned  # of the last command
    sent: Sequence[MotorCommand]  # the last ones, the latest first
    health: Health | None = None


class Stop(ABC):
    """A reason to stop; it may remember the ticks before."""

    @abstractmethod
    def find(self, moment: Moment) -> str:
        """The reason in words; "" for none."""


class Tilt(Stop):
    """The base leans away from its planned attitude, whatever the yaw."""

    def find(self, moment: Moment) -> str:
        angle = tilt_from(moment.planned.up, moment.readings.quat)
        if angle < TILTED:
            return ""
        return (
            f"tilt: {np.degrees(angle):.0f} deg from the plan, "
            f"at most {np.degrees(TILTED):.0f} are allowed"
        )


def tilt_from(up: Array, quat: Array) -> float:
    """Angle, rad, between the planned `up` (3,) and the one of an attitude (4,), base frame."""
    return float(np.arccos(np.clip(up @ up_of_quat(quat), -1.0, 1.0)))


class TrackingError(Stop):
    """A joint stays far from its planned position."""

    def __init__(self, robot: Robot) -> None:
        self._names = robot.joint_names
        self._ticks = np.zeros(len(self._names), dtype=np.int64)

    def find(self, moment: Moment) -> str:
        off = np.abs(moment.readings.q - moment.planned.q)
        self._ticks = np.where(off > MAX_TRACKING_ERROR, self._ticks + 1, 0)
        joint = int(self._ticks.argmax())
        if self._ticks[joint] * PERIOD < TRACKING_ERROR_FOR:
            return ""
        return (
            f"tracking: {self._names[joint]} is {off[joint]:.2f} rad from the plan, at most "
            f"{MAX_TRACKING_ERROR:g} are allowed"
        )


class UnresponsiveDrive(Stop):
    """A drive gives another torque than any of the commands that it may have by now."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._ticks = np.zeros(len(robot.joint_names), dtype=np.int64)

    def find(self, moment: Moment) -> str:
        if len(moment.sent) < UNDER_WAY:
            return ""
        readings, robot = moment.readings, self._robot
        limits = torque_range(robot, readings.dq)
        wanted = np.array(
            [np.clip(sent.torque(readings.q, readings.dq), *limits) for sent in moment.sent]
        )
        off = np.abs(readings.torque - wanted).min(axis=0) / robot.torque_limit
        self._ticks = np.where(off > MAX_TORQUE_ERROR, self._ticks + 1, 0)
        joint = int(self._ticks.argmax())
        if self._ticks[joint] * PERIOD < TORQUE_ERROR_FOR:
            return ""
        return (
            f"drive: {robot.joint_names[joint]} gives {readings.torque[joint]:.1f} Nm, "
            f"{wanted[0, joint]:.1f} Nm are commanded"
        )


class LateReadings(Stop):
    """Readings are later than they were at first, as far as two clocks can say."""

    def __init__(self) -> None:
        self._least = np.inf  # s: of the player's clock less the robot's
        self._ticks = 0

    def find(self, moment: Moment) -> str:
        apart = moment.now - moment.readings.time
        self._least = min(self._least, apart)
        late = apart - self._least
        self._ticks = self._ticks + 1 if late > LATE else 0
        if self._ticks * PERIOD < LATE_FOR:
            return ""
        return f"late: readings come {1e3 * late:.0f} ms late, at most {1e3 * LATE:.0f} are allowed"


class MissedDeadlines(Stop):
    """The player itself is too slow: its computer does something else."""

    def __init__(self) -> None:
        self._missed: deque[bool] = deque(maxlen=LAST_SENT)
        self._pause = 0.0
        self._awake: float | None = None

    def awake(self, now: float) -> None:
        """Take note that the player runs: once a period, with or without a reading."""
        if self._awake is not None:
            self._pause = now - self._awake
        self._awake = now

    def sent(self, received: float, now: float) -> None:
        """Take note of a command that was sent at `now` for a reading of `received`, s."""
        self._missed.append(now - received > DEADLINE)

    def find(self, moment: Moment) -> str:
        if self._pause > PAUSED:
            return (
                f"deadlines: the player stood still for {1e3 * self._pause:.0f} ms, at most "
                f"{1e3 * PAUSED:.0f} are allowed"
            )
        missed = sum(self._missed)
        if missed < MISSED:
            return ""
        return (
            f"deadlines: {missed} of the last {len(self._missed)} commands came more than "
            f"{1e3 * DEADLINE:.0f} ms after their reading, {MISSED - 1} are allowed"
        )


class Unwell(Stop):
    """Motors are hot or the battery is low, by what the robot says of itself."""

    def find(self, moment: Moment) -> str:
        health = moment.health
        if health is None:
            return ""
        if health.hottest > HOTTEST:
            return (
                f"temperature: a motor has {health.hottest:.0f} deg C, at most {HOTTEST:.0f} are "
                "allowed"
            )
        if health.charge is not None and health.charge < LEAST_CHARGE:
            return (
                f"battery: {100 * health.charge:.0f} % are left, at least {100 * LEAST_CHARGE:.0f} "
                "are needed"
            )
        return ""
