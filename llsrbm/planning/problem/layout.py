"""The variables of each knot, their units, and their places in the vector.

The horizon has the schedule's phases of n intervals each. Only what a phase needs is a variable:
no positions of feet that stand, no forces of feet that swing; the start is fixed. A phase's
duration T is a state with zero dynamics, chosen as a control when the phase begins, and so are the
first forces of feet that land and the first position and velocity of feet that leave.

A schedule that is under way begins with a robot that moves: its angular momentum and the feet that
swing are given, too. Where it lands next is free: all places after the next flight are shifted
alike, by a state with zero dynamics.

How much of a request is given up is a state with zero dynamics, too, from the first knot at which a
foot swings, chosen as a control in the interval before: see `problem.shortfall`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from llsrbm.arrays import Array, BoolArray, IntArray
from llsrbm.planning.problem.roles import Role, roles_of
from llsrbm.request.jump import COMPONENTS
from llsrbm.request.schedule import Schedule

BODY = ("position", "quat", "velocity", "momentum")
# Among the states of a knot, of which they are the first.
BODY_PLACES = {
    "position": slice(0, 3),
    "quat": slice(3, 7),
    "velocity": slice(7, 10),
    "momentum": slice(10, 13),
}
SHIFT = "shift"
SHORTFALL = "shortfall"  # state: shares of the ranges by which the request's components are reduced
NEXT_SHORTFALL = "next_shortfall"  # control: what they become
ARMS = ("arms", "arms_velocity", "arms_step")  # states, and what changes the second one
TURNED = "rotation_rate_before"  # state
_SIZES = dict.fromkeys(("position", "velocity", "momentum", "rotation_rate", TURNED), 3)
_SIZES |= {"quat": 4, SHIFT: 2}
_SIZES |= dict.fromkeys((SHORTFALL, NEXT_SHORTFALL), len(COMPONENTS))
SWING_NUMBERS = 3  # of a leg that each interval has for itself, see `shortfall.swing_numbers`
_SCALARS = ("duration", "next_duration")

LEAST_INTERVALS = 3  # of a phase
NOMINAL_PHASES = 3  # that share the number of intervals of a request


def split(intervals: int, schedule: Schedule) -> tuple[int, ...]:
    """Intervals of each phase: N / 3 each, times its share (the paper: N / 3 each)."""
    third, rest = divmod(intervals, NOMINAL_PHASES)
    counts = [max(LEAST_INTERVALS, round(third * phase.share)) for phase in schedule]
    counts[schedule.flights[0] if schedule.flights else 0] += rest
    return tuple(counts)


@dataclass(frozen=True)
class Layout:
    """Names, sizes and places of all variables.

    In scaled units: position m; quat w, x, y, z; velocity m/s; momentum (angular, about the CoM)
    L / m in m2/s; force in m g / contacts; duration s; feet x_i, (d, legs), m in the hip frames,
    with d = 4 their yaw, rad; feet_velocity, that of the interval before, m/s, rad/s; feet_step,
    what is added to it as an interval begins, m/s, rad/s; feet_stop, what is added at touchdown;
    arms: the joints of free arms, rad, in all phases alike; arms_velocity, arms_step: as of feet,
    rad/s, the first interval goes on as it begins; rotation_rate: the base's angular velocity over
    the interval, base axes, rad/s; rotation_rate_before: of the interval before, with free arms,
    whose drives feel it change; shift: of where feet land, horizontally, m; shortfall: shares of
    the ranges. A variable of feet or forces has the legs of `legs_of`.

    Attributes:
        contacts: C, L times the corners of a foot.
        stands: (P, L) whether a foot stands in a phase.
        intervals: (P,) of each phase.
        foot_coordinates: d, see `Robot.foot_coordinates`.
        clears: whether the whole body has something to clear (`constraints.body_clearance`).
        turns: whether the body turns over, so fast that legs feel it.
        under_way: whether it begins in motion, and where feet land next is free.
        arm_joints: of all arms that are free.
        apex: whether the apex of flights is limited.
        places_before, places_after: (P, L) the place in which each foot stands in a phase, or stood
            last; stands, or stands next; () where no less than the request may be done.
    """

    contacts: int
    stands: tuple[tuple[bool, ...], ...]
    intervals: tuple[int, ...]
    foot_coordinates: int = 3
    clears: bool = False
    turns: bool = False
    under_way: bool = False
    arm_joints: int = 0
    apex: bool = False
    places_before: tuple[tuple[int, ...], ...] = ()
    places_after: tuple[tuple[int, ...], ...] = ()

    @classmethod
    def of(
        cls,
        schedule: Schedule,
        contacts: int,
        intervals: int,
        foot_coordinates: int,
        *,
        clears: bool = False,
        turns: bool = False,
        arm_joints: int = 0,
        apex: bool = False,
    ) -> Layout:
        """Layout of a schedule; `intervals` as for three phases.

        Whole turns are not done in part, and a motion under way lands where it can already.
        """
        stands = tuple(tuple(bool(foot) for foot in row) for row in schedule.stands)
        counts, under_way = split(intervals, schedule), schedule.under_way
        shape = contacts, stands, counts, foot_coordinates
        places: list[tuple[tuple[int, ...], ...]] = []
        if not turns and not under_way:
            each = schedule.places_before, schedule.places_after
            places = [tuple(map(tuple, rows.tolist())) for rows in each]
        return cls(*shape, clears, turns, under_way, arm_joints, apex, *places)

    @property
    def own_numbers(self) -> int:
        """Parameters that each interval has for itself."""
        turning = 2 * self.legs if self.turns else 0
        return 3 + turning + (SWING_NUMBERS * self.legs if self.gives else 0)

    @property
    def gives(self) -> bool:
        """Whether less than the request may be done."""
        return bool(self.places_after)

    @property
    def displacements(self) -> int:
        """K, of the schedule."""
        return max(map(max, self.places_after))

    @property
    def legs(self) -> int:
        """L."""
        return len(self.stands[0])

    @property
    def phases(self) -> int:
        """P."""
        return len(self.stands)

    @property
    def corners(self) -> int:
        """Contact points of a foot."""
        return self.contacts // self.legs

    @property
    def total(self) -> int:
        """N intervals."""
        return sum(self.intervals)

    @property
    def knots(self) -> int:
        """N + 1."""
        return self.total + 1

    @property
    def name(self) -> str:
        """The feet that stand in each phase, for names of files: "1111-0000-1111"."""
        text = "-".join("".join(str(int(foot)) for foot in row) for row in self.stands)
        flags = {
            "-clears": self.clears,
            "-turns": self.turns,
            "-under-way": self.under_way,
            "-arms": self.arm_joints > 0,
            "-apex": self.apex,
        }
        return text + "".join(tag for tag, on in flags.items() if on)

    @cached_property
    def roles(self) -> tuple[Role, ...]:
        """(N + 1) roles."""
        return roles_of(
            self.stands,
            self.intervals,
            clears=self.clears,
            turns=self.turns,
            under_way=self.under_way,
            moves_arms=self.arm_joints > 0,
            apex=self.apex,
            places=tuple(zip(self.places_before, self.places_after, strict=True)),
        )

    @cached_property
    def phase(self) -> IntArray:
        """(N + 1,) index of each knot's phase."""
        return np.array([role.phase for role in self.roles], dtype=np.int64)

    @cached_property
    def progress(self) -> Array:
        """(N + 1,) share of the knot's phase that is over, 0 ... 1."""
        return np.concatenate([*(np.arange(c) / c for c in self.intervals), [1.0]])

    @cached_property
    def standing(self) -> BoolArray:
        """(N + 1, L) whether a foot stands over the interval that starts at the knot."""
        return np.array(self.stands)[self.phase]

    @cached_property
    def first_knots(self) -> IntArray:
        """(P + 1,) knots at which phases begin, and the last."""
        return np.concatenate([[0], np.cumsum(self.intervals)]).astype(np.int64)

    @cached_property
    def swings(self) -> tuple[tuple[int, int, int], ...]:
        """(leg, knot of lift-off, knot of touchdown) of every swing of every foot."""
        found = []
        for leg in range(self.legs):
            stands = self.standing[:, leg]
            edges = np.flatnonzero(stands[1:] != stands[:-1]) + 1
            if not stands[0]:  # under way: what is left of a swing
                edges = np.concatenate([[0], edges])
            found += [(leg, int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]
        return tuple(found)

    @cached_property
    def swing_progress(self) -> tuple[Array, Array]:
        """(N + 1, L) share of a foot's swing that is over, by knots, and a knot's share of it.

        NaN at knots at which the foot stands, the two ends not among them.
        """
        progress, step = np.full((2, self.knots, self.legs), np.nan)
        for leg, lift, touch in self.swings:
            progress[lift : touch + 1, leg] = np.arange(touch - lift + 1) / (touch - lift)
            step[lift : touch + 1, leg] = 1 / (touch - lift)
        return progress, step

    def legs_of(self, name: str, role: Role) -> tuple[int, ...]:
        """The legs that a variable has; () of one that is the body's."""
        sets = {
            "feet": role.in_air,
            "feet_velocity": role.in_air,
            "feet_step": role.swinging,
            "feet_stop": role.touching_down,
            "next_feet": role.lifting_off,
            "next_feet_velocity": role.lifting_off,
            "force": role.standing,
            "force_step": role.remaining if role.last else role.standing,
            "next_force": role.touching_down,
        }
        return sets.get(name, ())

    def size(self, name: str, role: Role) -> int:
        """Scalars of the variable called `name` at a knot of that role."""
        if name in _SIZES:
            return _SIZES[name]
        if name in _SCALARS:
            return 1
        if name in ARMS:
            return self.arm_joints
        per_leg = 3 * self.corners if "force" in name else self.foot_coordinates
        return per_leg * len(self.legs_of(name, role))

    def states(self, role: Role) -> tuple[str, ...]:
        """Names of the states at a knot of that role."""
        landing = ((SHIFT, role.shifts), (SHORTFALL, role.has_shortfall))
        where = tuple(name for name, there in landing if there)
        moves_arms = role.moves_arms and not role.initial
        if role.terminal:
            return (*BODY, *(ARMS[:2] if moves_arms else ()), *where)
        arms = (*ARMS[:2], TURNED) if moves_arms else ()
        feet = ("feet", "feet_velocity") if role.in_air and not role.initial else ()
        force = ("force",) if role.standing else ()
        return (*(() if role.initial else BODY), *arms, *feet, *force, "duration", *where)

    def controls(self, role: Role) -> tuple[str, ...]:
        """Names of the controls over the interval that starts at a knot of that role."""
        if role.terminal:
            return ()
        names = ["force_step"] if self._force_steps(role) else []
        names += [ARMS[2]] if role.moves_arms and not role.initial else []
        names += ["feet_step"] if role.swinging else []
        names += ["feet_stop"] if role.touching_down else []
        names += ["next_feet", "next_feet_velocity"] if role.lifting_off else []
        names += ["next_force"] if role.touching_down else []
        names += ["next_duration"] if role.last and not role.final else []
        return (*names, "rotation_rate", *((NEXT_SHORTFALL,) if role.chooses_shortfall else ()))

    @staticmethod
    def _force_steps(role: Role) -> bool:
        if not role.standing:
            return False
        return not role.last or (not role.final and bool(role.remaining))

    def state_size(self, role: Role) -> int:
        """nx of a stage."""
        return sum(self.size(name, role) for name in self.states(role))

    def control_size(self, role: Role) -> int:
        """nu of a stage."""
        return sum(self.size(name, role) for name in self.controls(role))

    @cached_property
    def _places(self) -> tuple[dict[str, slice], ...]:
        places, start = [], 0
        for role in self.roles:
            here = {}
            for name in (*self.states(role), *self.controls(role)):
                here[name] = slice(start, start + self.size(name, role))
                start += self.size(name, role)
            places.append(here)
        return tuple(places)

    @property
    def size_total(self) -> int:
        """Number of variables of the whole problem."""
        return sum(self.state_size(r) + self.control_size(r) for r in self.roles)

    def variables(self, knot: int) -> dict[str, slice]:
        """Name -> place in the vector of all variables, states first."""
        return self._places[knot]

    def places(self, name: str) -> IntArray:
        """(n, size) places of a variable in the vector, a row for each knot that has it."""
        rows = (here[name] for here in self._places if name in here)
        return np.array([np.arange(row.start, row.stop) for row in rows])

    def stage(self, knot: int) -> slice:
        """Place of all of a knot's variables in the vector."""
        places = tuple(self._places[knot].values())
        return slice(places[0].start, places[-1].stop)

    def normalised(self, w: Array) -> Array:
        """All variables, quaternions of length 1."""
        w, quats = w.copy(), self.places("quat")
        w[quats] /= np.linalg.norm(w[quats], axis=1, keepdims=True)
        return w

    def blocks(self) -> Iterator[tuple[Role, range]]:
        """Runs of knots with the same role, in order."""
        start = 0
        for k in range(1, self.knots + 1):
            if k == self.knots or self.roles[k] != self.roles[start]:
                yield self.roles[start], range(start, k)
                start = k
