"""The player's states: check, ramp, stand, jump, damp; each makes commands until it is over."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from llsrbm.arrays import Array
from llsrbm.control.motor_command import MotorCommand
from llsrbm.control.readings import Readings
from llsrbm.player.posture import Planned, brake, gains, up_of_quat
from llsrbm.player.round_trip import RoundTrip
from llsrbm.player.stops import LATE, tilt_from
from llsrbm.player.tier import Tier

CHECKS_FOR = 0.5  # s of readings, without a command
UPRIGHT = np.radians(20.0)  # of a robot that lies on its belly or stands
AT_REST = 0.5  # rad/s (m/s): noise of a speed is a tenth of it
# rad (m) from which a robot that lies is brought into the plan's posture; a joint further away is
# one whose zero or sign is wrong.
WITHIN_REACH = 2.0
BEYOND_STOP = 0.1  # rad (m): likewise
RAMP_SPEED = 1.0  # rad/s (m/s), the fastest that a joint is moved there
LEAST_RAMP = 0.5  # s
STANDS_FOR = 1.0  # s before the jump
# From the plan's first posture, and attitude, as it begins.
STANDS_WITHIN, STANDS_UPRIGHT = 0.15, np.radians(6.0)  # rad (m), rad
DAMPS_FOR = 2.0  # s; a robot has folded by then


class State(ABC):
    """A state, from its first reading on; times are s by the robot's clock."""

    name: ClassVar[str]
    summary: ClassVar[str]  # to those who watch
    duration: float  # s, planned

    def __init__(self, tier: Tier, start: float) -> None:
        self.tier, self.start = tier, start

    @abstractmethod
    def command(self, readings: Readings) -> MotorCommand | None:
        """The command of the tick that begins with readings; None: only listen."""

    @abstractmethod
    def following(self, time: float) -> State:
        """The state that comes next."""

    def over(self, time: float) -> bool:
        """True if the next state begins."""
        return time - self.start >= self.duration - 1e-6

    def wrong(self, readings: Readings) -> str:
        """A reason to stop, in words, of the state's own; "" if there is none."""
        return ""

    def planned(self, readings: Readings) -> Planned:
        """Where joints and attitude should be."""
        return self.tier.first.planned


class Check(State):
    """Listens: is the robot upright, at rest, and in a posture from which it can be brought up."""

    name = "check"
    summary = "listens: posture, tilt, battery"
    duration = CHECKS_FOR

    def command(self, readings: Readings) -> None:
        """Nothing is sent yet."""

    def wrong(self, readings: Readings) -> str:
        first, robot = self.tier.first, self.tier.robot
        if not all(np.isfinite(v).all() for v in (readings.q, readings.dq, readings.quat)):
            return "posture: the readings are not finite"
        tilted = tilt_from(np.array([0.0, 0.0, 1.0]), readings.quat)
        if tilted > UPRIGHT:
            return (
                f"posture: the base is tilted by {np.degrees(tilted):.0f} deg, expected at most "
                f"{np.degrees(UPRIGHT):.0f}"
            )
        lower, upper = robot.joint_stops
        beyond = np.maximum(lower - readings.q, readings.q - upper)
        moves = np.abs(readings.dq) * self.over(readings.time)  # at last, not at first
        for off, most, words in (
            (np.abs(readings.q - first.joints), WITHIN_REACH, "rad from the plan's first posture"),
            (beyond, BEYOND_STOP, "rad beyond its stop"),
            (moves, AT_REST, "rad/s fast"),
        ):
            joint = int(off.argmax())
            if off[joint] > most:
                name = robot.joint_names[joint]
                return f"posture: {name} is {off[joint]:.2f} {words}, expected at most {most:g}"
        return ""

    def planned(self, readings: Readings) -> Planned:
        """Nothing is asked of it yet."""
        return Planned(readings.q, up_of_quat(readings.quat))

    def following(self, time: float) -> State:
        return Ramp(self.tier, time)


class Ramp(State):
    """Brings the joints into the plan's first posture, smoothly, and lets them bear the weight.

    It begins with the posture and the torques that are there, so nothing moves at once. On the way
    it probes how late commands are followed.
    """

    name = "ramp"
    summary = "into the plan's first posture"

    def __init__(self, tier: Tier, start: float) -> None:
        super().__init__(tier, start)
        self._from: Array | None = None
        self._bears = np.zeros(len(tier.robot.joint_names))
        self._gains = gains(tier.robot)
        self._round_trip = RoundTrip(tier.robot)
        self.duration = LEAST_RAMP
        self._planned = tier.first.planned

    def command(self, readings: Readings) -> MotorCommand:
        first = self.tier.first
        if self._from is None:
            self._from, self._bears = readings.q, readings.torque
            self.duration = ramp_duration(self.tier, readings.q)
        s = min(max((readings.time - self.start) / self.duration, 0.0), 1.0)
        share, rate = s * s * (3 - 2 * s), 6 * s * (1 - s) / self.duration
        way = first.joints - self._from
        q = self._from + share * way
        self._planned = Planned(q, self._planned.up)
        torque = (1 - share) * self._bears + share * first.torque
        torque = torque + self._round_trip.probe(readings.time - self.start)
        command = MotorCommand(q, rate * way, torque, *self._gains)
        self._round_trip.read(readings)
        self._round_trip.sent(command)
        return command

    def wrong(self, readings: Readings) -> str:
        delay = self._round_trip.delay
        if not self.over(readings.time) or delay <= LATE:
            return ""
        return (
            f"late: the drives follow commands after {1e3 * delay:.0f} ms, at most "
            f"{1e3 * LATE:.0f} are allowed"
        )

    def planned(self, readings: Readings) -> Planned:
        if self._from is None:
            return Planned(readings.q, self._planned.up)
        return self._planned

    def following(self, time: float) -> State:
        return Stand(self.tier, time)


class Stand(State):
    """Stands in the plan's first posture, as the tier does it."""

    name = "stand"
    summary = "in the plan's first posture"
    duration = STANDS_FOR

    def command(self, readings: Readings) -> MotorCommand:
        return self.tier.command(readings.time - self.start - self.duration, readings)

    def planned(self, readings: Readings) -> Planned:
        return self.tier.planned(readings.time - self.start - self.duration)

    def wrong(self, readings: Readings) -> str:
        if not self.over(readings.time):
            return self.tier.trouble
        first = self.tier.first
        off = np.abs(readings.q - first.joints)
        joint = int(off.argmax())
        if off[joint] > STANDS_WITHIN:
            return (
                f"posture: {self.tier.robot.joint_names[joint]} is {off[joint]:.2f} rad from "
                f"the plan's first posture, expected at most {STANDS_WITHIN:g}"
            )
        tilted = tilt_from(first.planned.up, readings.quat)
        if tilted > STANDS_UPRIGHT:
            return (
                f"posture: the base is {np.degrees(tilted):.0f} deg from the plan's first "
                f"attitude, expected at most {np.degrees(STANDS_UPRIGHT):.0f}"
            )
        return ""

    def following(self, time: float) -> State:
        return Jumping(self.tier, time)


class Jumping(State):
    """The plan, and standing where it ends."""

    name = "jump"
    summary = "the plan, and a second of standing after it"

    def __init__(self, tier: Tier, start: float) -> None:
        super().__init__(tier, start)
        self.duration = tier.end

    def command(self, readings: Readings) -> MotorCommand:
        return self.tier.command(readings.time - self.start, readings)

    def planned(self, readings: Readings) -> Planned:
        return self.tier.planned(readings.time - self.start)

    def wrong(self, readings: Readings) -> str:
        return self.tier.trouble

    def following(self, time: float) -> State:
        return Damp(self.tier, time)


class Damp(State):
    """Brakes alone, whatever the readings; `start` is by the player's own clock."""

    name = "damp"
    summary = "brakes alone"
    duration = DAMPS_FOR

    def __init__(self, tier: Tier, start: float) -> None:
        super().__init__(tier, start)
        self.brake = brake(tier.robot)

    def command(self, readings: Readings) -> MotorCommand:
        return self.brake

    def following(self, time: float) -> State:
        return self


def outline(tier: Tier, joints: Array) -> list[tuple[str, float, str]]:
    """Name, duration (s) and purpose of all states, for a robot that begins with joints (J,)."""
    ramp = Ramp(tier, 0.0)
    ramp.duration = ramp_duration(tier, joints)
    states = (Check(tier, 0.0), ramp, Stand(tier, 0.0), Jumping(tier, 0.0), Damp(tier, 0.0))
    return [(state.name, state.duration, state.summary) for state in states]


def ramp_duration(tier: Tier, joints: Array) -> float:
    """S from joints (J,) into the plan's first posture."""
    far = float(np.abs(tier.first.joints - joints).max())
    # A smooth step is half as fast again in its middle as on average.
    return max(LEAST_RAMP, 1.5 * far / RAMP_SPEED)
