"""Which variables exist at which knot, in which units, and where they sit in the vector.

The horizon has three phases of n intervals each. Only what a phase needs is a variable: no foot
positions in contact, no forces in flight; the start is fixed. A phase's duration T is a state with
zero dynamics, chosen as a control when the phase begins, and so are the first forces of the landing
and the feet's first position and velocity in flight.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from llsrbm.motion.plan import Phase

Array = NDArray[np.float64]

# The parameters that say where feet stand: their middles, their contact points, their headings.
STANDING = {when: (f"{when}_feet", f"{when}_contacts", f"{when}_yaw") for when in ("start", "goal")}

BODY = ("position", "quat", "velocity", "momentum")


@dataclass(frozen=True)
class Intervals:
    """Intervals of take-off, flight and landing (at least 3 each)."""

    takeoff: int = 16
    flight: int = 16
    landing: int = 16

    @property
    def total(self) -> int:
        """N."""
        return self.takeoff + self.flight + self.landing

    @classmethod
    def split(cls, total: int) -> Intervals:
        """N intervals over the three phases as evenly as can be (the paper: N / 3 each)."""
        third, rest = divmod(total, 3)
        return cls(third, third + rest, third)


@dataclass(frozen=True)
class Role:
    """What kind of stage a knot has; knots of one role share their expressions."""

    phase: Phase
    first: bool = False
    last: bool = False
    terminal: bool = False

    @property
    def in_contact(self) -> bool:
        """Whether forces act over the interval that starts here."""
        return self.phase != Phase.FLIGHT and not self.terminal

    def describe(self) -> str:
        """For names of functions and messages."""
        tags = ("first", self.first), ("last", self.last), ("terminal", self.terminal)
        return "_".join([self.phase.name.lower(), *(tag for tag, on in tags if on)])


@dataclass(frozen=True)
class Layout:
    """Names, sizes and places of all variables.

    In scaled units: position m; quat w, x, y, z; velocity m/s; momentum (angular, about the CoM)
    L / m in m2/s; force in m g / contacts; duration s; feet x_i, (d L), m in the hip frames, with
    d = 4 their yaw, rad; feet_velocity, that of the interval before, m/s, rad/s; feet_step, what is
    added to it as an interval begins, m/s, rad/s; feet_stop, what is added at touchdown;
    rotation_rate: the base's angular velocity over the
    interval, base axes, rad/s.

    Attributes:
        legs: L; contacts: C, L times the corners of a foot.
        intervals: N, by phase.
        foot_coordinates: d, see `Robot.foot_coordinates`.
    """

    legs: int
    contacts: int
    intervals: Intervals
    foot_coordinates: int = 3

    @property
    def corners(self) -> int:
        """Contact points of a foot."""
        return self.contacts // self.legs

    @property
    def knots(self) -> int:
        """N + 1."""
        return self.intervals.total + 1

    @cached_property
    def roles(self) -> tuple[Role, ...]:
        """(N + 1) roles."""
        n = self.intervals
        roles = []
        counts = (n.takeoff, n.flight, n.landing)
        for phase, count in zip(Phase, counts, strict=True):
            roles += [Role(phase, first=k == 0, last=k == count - 1) for k in range(count)]
        return (*roles, Role(Phase.LANDING, terminal=True))

    @cached_property
    def progress(self) -> Array:
        """(N + 1,) share of the knot's phase that is over, 0 ... 1."""
        n = self.intervals
        parts = [np.arange(c) / c for c in (n.takeoff, n.flight, n.landing)]
        return np.concatenate([*parts, [1.0]])

    def intervals_of(self, phase: Phase) -> int:
        """Number of intervals of a phase."""
        return (self.intervals.takeoff, self.intervals.flight, self.intervals.landing)[phase]

    def size(self, name: str) -> int:
        """Scalars of the variable called `name`."""
        sizes = {
            "position": 3,
            "quat": 4,
            "velocity": 3,
            "momentum": 3,
            "rotation_rate": 3,
            "duration": 1,
            "next_duration": 1,
        }
        if name in sizes:
            return sizes[name]
        return 3 * self.contacts if "force" in name else self.foot_coordinates * self.legs

    def states(self, role: Role) -> tuple[str, ...]:
        """Names of the states at a knot of that role."""
        if role.terminal:
            return BODY
        if role.phase == Phase.FLIGHT:
            return (*BODY, "feet", "feet_velocity", "duration")
        if role.phase == Phase.TAKEOFF and role.first:
            return ("force", "duration")
        if role.phase == Phase.LANDING and role.first:
            return (*BODY, "feet", "feet_velocity", "force", "duration")
        return (*BODY, "force", "duration")

    def controls(self, role: Role) -> tuple[str, ...]:
        """Names of the controls over the interval that starts at a knot of that role."""
        if role.terminal:
            return ()
        rate = ("rotation_rate",)
        if role.phase == Phase.FLIGHT:
            stop = ("feet_stop",) if role.last else ()
            start = ("next_force", "next_duration") if role.last else ()
            return ("feet_step", *stop, *start, *rate)
        if role.phase == Phase.TAKEOFF and role.last:
            return ("next_feet", "next_feet_velocity", "next_duration", *rate)
        return rate if role.last else ("force_step", *rate)

    def state_size(self, role: Role) -> int:
        """nx of a stage."""
        return sum(self.size(name) for name in self.states(role))

    def control_size(self, role: Role) -> int:
        """nu of a stage."""
        return sum(self.size(name) for name in self.controls(role))

    @cached_property
    def _places(self) -> tuple[dict[str, slice], ...]:
        places, start = [], 0
        for role in self.roles:
            here = {}
            for name in (*self.states(role), *self.controls(role)):
                here[name] = slice(start, start + self.size(name))
                start += self.size(name)
            places.append(here)
        return tuple(places)

    @property
    def size_total(self) -> int:
        """Number of variables of the whole problem."""
        return sum(self.state_size(r) + self.control_size(r) for r in self.roles)

    def variables(self, knot: int) -> dict[str, slice]:
        """Name -> place in the vector of all variables, states first."""
        return self._places[knot]

    def blocks(self) -> Iterator[tuple[Role, range]]:
        """Runs of knots with the same role, in order."""
        start = 0
        for k in range(1, self.knots + 1):
            if k == self.knots or self.roles[k] != self.roles[start]:
                yield self.roles[start], range(start, k)
                start = k
