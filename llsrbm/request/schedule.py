"""The contact schedule of a jump: which feet stand in which phase, for how long, and where.

A schedule is data. `llsrbm.request.jump_types` makes it from a preset or a person's file, the
planner iterates over it, a plan stores it, and everything that follows a plan reads it from there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from llsrbm.arrays import BoolArray, IntArray
from llsrbm.errors import InputError, printable

LONGEST_NAME = 40  # characters of a phase's; it stands on a strip of the timeline
TIMINGS = ("takeoff", "flight", "landing")
"""Rows of a robot file's [timing], which a phase may take its limits from."""


@dataclass(frozen=True)
class Phase:
    """A stretch of the motion in which the same feet stand."""

    name: str  # as on the timeline, such as "take-off"
    feet: tuple[str, ...]  # names of the legs whose feet stand; () in flight
    # Shortest and longest duration, s, or the row of the robot file's [timing] that says.
    time: str | tuple[float, float]
    place: int = 0  # where standing feet stand: 0 at the start, k after the k-th displacement
    share: float = 1.0  # of the intervals that a whole phase gets

    @property
    def is_flight(self) -> bool:
        """True if no foot stands."""
        return not self.feet


@dataclass(frozen=True)
class Schedule:
    """Phases in order, from standing on all feet to standing on all feet. Raises `InputError`:
    phases that cannot be; one line that says which, and what would be accepted.
    """

    legs: tuple[str, ...]  # names of all legs, in the robot's order
    # At least three; the first and the last on all feet, one of them a flight.
    phases: tuple[Phase, ...]
    # Whether it is what is left of another one, which has begun; then any phases that end on all
    # feet.
    under_way: bool = False

    def __post_init__(self) -> None:
        if not self.under_way:
            _check(self)

    def __iter__(self) -> Iterator[Phase]:
        return iter(self.phases)

    def __len__(self) -> int:
        return len(self.phases)

    def __getitem__(self, phase: int) -> Phase:
        return self.phases[phase]

    @cached_property
    def stands(self) -> BoolArray:
        """(P, L) whether a foot stands in a phase."""
        return np.array([[leg in phase.feet for leg in self.legs] for phase in self.phases])

    @cached_property
    def places_before(self) -> IntArray:
        """(P, L) the place in which a foot stands in a phase, or stood last."""
        before = np.full(self.stands.shape, self.phases[0].place, dtype=np.int64)
        for p, phase in enumerate(self):
            before[p] = np.where(self.stands[p], phase.place, before[max(p - 1, 0)])
        return before

    @cached_property
    def places_after(self) -> IntArray:
        """(P, L) the place in which a foot stands in a phase, or stands next."""
        after = self.places_before.copy()
        for p in reversed(range(len(self) - 1)):
            after[p] = np.where(self.stands[p], self.phases[p].place, after[p + 1])
        return after

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the phases."""
        return tuple(phase.name for phase in self.phases)

    @cached_property
    def flights(self) -> tuple[int, ...]:
        """Indices of the phases in which no foot stands, in order."""
        return tuple(k for k, phase in enumerate(self.phases) if phase.is_flight)

    @property
    def is_caught(self) -> bool:
        """True if some feet land before the others after the last flight."""
        after = self.stands[self.flights[-1] + 1] if self.flights else self.stands[-1]
        return not after.all()

    @property
    def places(self) -> int:
        """Number of displacements: the last phase's place."""
        return self.phases[-1].place

    def rest(self, phase: int, time: tuple[float, float]) -> Schedule:
        """The rest of it from a phase on that may still take `time`, shortest and longest, s."""
        first = replace(self.phases[phase], time=time)
        return Schedule(self.legs, (first, *self.phases[phase + 1 :]), under_way=True)

    def lifts(self, phase: int) -> BoolArray:
        """(L,) feet that leave the ground as a phase begins."""
        before = self.stands[max(phase - 1, 0)]
        return before & ~self.stands[phase]

    def lands(self, phase: int) -> BoolArray:
        """(L,) feet that meet the ground as a phase begins."""
        before = self.stands[max(phase - 1, 0)]
        return ~before & self.stands[phase]

    def standing_words(self, phase: int) -> str:
        """The feet that stand in a phase, for people: "all feet", "no foot", or their names."""
        feet = self.phases[phase].feet
        if len(feet) == len(self.legs):
            return "all feet"
        return ", ".join(feet) or "no foot"

    def as_dict(self) -> dict[str, Any]:
        """Plain data, for files."""
        return {
            "legs": list(self.legs),
            "phases": [
                {n: list(v) if isinstance(v, tuple) else v for n, v in vars(phase).items()}
                for phase in self.phases
            ],
        }

    @classmethod
    def from_dict(cls, table: dict[str, Any]) -> Schedule:
        """The schedule that `as_dict` wrote, checked. Raises `InputError`: it is no schedule."""
        try:
            phases = tuple(_phase(row) for row in table["phases"])
            legs = tuple(_text(leg) for leg in table["legs"])
        except (LookupError, TypeError, ValueError, OverflowError) as error:
            raise InputError(
                f"schedule: not one that this version wrote ({printable(repr(error))}); expected "
                'what "as_dict" gives'
            ) from error
        return cls(legs, phases)


def together(legs: tuple[str, ...]) -> Schedule:
    """Take-off from all feet, flight, landing on all feet: the schedule of files without one."""
    return Schedule(
        legs,
        (
            Phase("take-off", legs, "takeoff"),
            Phase("flight", (), "flight"),
            Phase("landing", legs, "landing", place=1),
        ),
    )


def _phase(row: dict[str, Any]) -> Phase:
    time, place = row["time"], row["place"]
    if not isinstance(time, str):
        shortest, longest = time
        time = (float(shortest), float(longest))
    if isinstance(place, bool) or not isinstance(place, int):
        raise TypeError(f"place {place!r}")
    feet = tuple(_text(foot) for foot in row["feet"])
    return Phase(_text(row["name"]), feet, time, place, float(row["share"]))


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{value!r} is no text")
    return value


def _check(schedule: Schedule) -> None:
    legs, phases = schedule.legs, schedule.phases
    named = all(leg and leg.isprintable() for leg in legs)
    if not legs or not named or len(set(legs)) < len(legs):
        raise InputError(
            f"schedule: it has the legs {printable(', '.join(legs))!r}; expected names, each once"
        )
    if len(phases) < 3:
        raise InputError(
            f"schedule: it has {len(phases)} phases; expected at least three: a take-off, a "
            "flight and a landing"
        )
    for k, phase in enumerate(phases):
        where = f'schedule: phase {k + 1}, "{printable(phase.name)}"'
        if not (phase.name.isprintable() and 1 <= len(phase.name) <= LONGEST_NAME):
            raise InputError(f"{where}: expected a name of 1 to {LONGEST_NAME} printable letters")
        for foot in phase.feet:
            if foot not in legs:
                raise InputError(
                    f'{where}: unknown foot "{printable(foot)}"; the feet are {", ".join(legs)}'
                )
            if phase.feet.count(foot) > 1:
                raise InputError(f"{where}: foot {foot} is named twice; expected every foot once")
        _check_time(where, phase)
        if not 0.1 <= phase.share <= 4.0:
            raise InputError(f"{where}: share {phase.share:g}; expected 0.1 to 4")
    for k, when in ((0, "begins"), (len(phases) - 1, "ends")):
        missing = [leg for leg in legs if leg not in phases[k].feet]
        if missing:
            raise InputError(
                f'schedule: it {when} with "{phases[k].name}", in which {", ".join(missing)} '
                f"{'does' if len(missing) == 1 else 'do'} not stand; expected all feet to stand"
            )
    if not schedule.flights:
        raise InputError("schedule: it has no flight; expected a phase in which no foot stands")
    for k, (before, after) in enumerate(pairwise(phases)):
        if set(before.feet) == set(after.feet):
            raise InputError(
                f'schedule: phases {k + 1}, "{before.name}", and {k + 2}, "{after.name}", have '
                "the same feet on the ground; expected one phase in place of both"
            )
        if before.feet and after.feet and before.place != after.place:
            raise InputError(
                f'schedule: between "{before.name}" and "{after.name}" feet stand in place '
                f"{before.place} and {after.place}; expected a flight between two places"
            )
        if not 0 <= after.place - before.place <= 1 or phases[0].place != 0:
            raise InputError(
                "schedule: places are expected to begin at 0 and to grow by one with each flight"
            )
    if phases[-1].place < 1:
        raise InputError("schedule: it has no end; expected a landing in place 1 or later")


def _check_time(where: str, phase: Phase) -> None:
    if isinstance(phase.time, str):
        if phase.time not in TIMINGS:
            raise InputError(
                f'{where}: time "{printable(phase.time)}"; expected {", ".join(TIMINGS)}, or two '
                "numbers, s"
            )
        return
    low, high = phase.time
    if not (np.isfinite(low) and np.isfinite(high) and 0.02 <= low < high <= 3.0):
        raise InputError(
            f"{where}: time {low:g} to {high:g} s; expected the shortest and the longest, of "
            "0.02 to 3 s"
        )
