"""The roles of a horizon's knots: which feet stand, leave, swing and land there, and what begins.

Which variables a knot has, and which constraints, follows from its role alone.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from llsrbm.arrays import BoolArray


@dataclass(frozen=True)
class Role:
    """Kind of a knot's stage; knots of one role share their expressions.

    Attributes:
        phase: index.
        intervals: of the phase.
        standing: legs whose feet stand over the interval that starts here; swinging: the others.
        leaving, landing: at a phase's first knot, legs whose feet have just left or met the ground.
        lifting_off, touching_down: over a phase's last interval, legs whose feet leave or meet the
            ground at its end.
        at_edge: legs that lift off or land, where they must not outrun their drives; of a body
            that turns over, whose knees do as it lands, those that lift off.
        initial: the very first knot; terminal: the very last, after which nothing follows.
        first, last: of the phase's intervals.
        final: in the schedule's last phase.
        clears: whether trunk, knees and flying feet are kept clear of something.
        leans: before the last flight of a body that turns over; lands_upright: after it.
        under_way: of a motion that began under way.
        moves_arms: whether the robot has arms that are free.
        limits_apex: at the first knot of a flight whose apex is limited.
        shifts: whether where feet will land is a variable; shifted: whether they have landed there.
        places_before, places_after: (L,) place in which each foot stands, or stood last; stands, or
            stands next; () where no less than the request may be done.
        has_shortfall: whether what is given up of the request is known, a state.
        chooses_shortfall: whether it is chosen over the interval that starts here.
    """

    phase: int
    intervals: int
    standing: tuple[int, ...]
    swinging: tuple[int, ...]
    leaving: tuple[int, ...] = ()
    landing: tuple[int, ...] = ()
    lifting_off: tuple[int, ...] = ()
    touching_down: tuple[int, ...] = ()
    at_edge: tuple[int, ...] = ()
    initial: bool = False
    terminal: bool = False
    first: bool = False
    last: bool = False
    final: bool = False
    clears: bool = False
    leans: bool = False
    lands_upright: bool = False
    under_way: bool = False
    moves_arms: bool = False
    limits_apex: bool = False
    shifts: bool = False
    shifted: bool = False
    places_before: tuple[int, ...] = ()
    places_after: tuple[int, ...] = ()
    has_shortfall: bool = False
    chooses_shortfall: bool = False

    @property
    def in_contact(self) -> bool:
        """True if forces act over the interval that starts here."""
        return bool(self.standing) and not self.terminal

    @property
    def in_air(self) -> tuple[int, ...]:
        """Legs whose feet are variables at the knot: those that swing, and those just landed."""
        return tuple(sorted({*self.swinging, *self.landing}))

    @property
    def flying(self) -> tuple[int, ...]:
        """Legs whose feet are off the ground at the knot and after it."""
        return tuple(leg for leg in self.swinging if leg not in self.leaving)

    @property
    def flies(self) -> bool:
        """True if feet are off the ground at the knot, which is not where it all begins."""
        return bool(self.flying) and not self.initial

    @property
    def remaining(self) -> tuple[int, ...]:
        """Standing legs whose feet stand after the interval, too."""
        return tuple(leg for leg in self.standing if leg not in self.lifting_off)

    @property
    def is_flight(self) -> bool:
        """True if no foot stands."""
        return not self.standing

    @property
    def lands_shifted(self) -> bool:
        """True if where feet land as the interval ends is shifted: from the next flight on."""
        return self.shifted or (self.shifts and self.is_flight)


def roles_of(
    stands: tuple[tuple[bool, ...], ...],
    intervals: tuple[int, ...],
    *,
    clears: bool = False,
    turns: bool = False,
    under_way: bool = False,
    moves_arms: bool = False,
    apex: bool = False,
    places: tuple[tuple[tuple[int, ...], tuple[int, ...]], ...] = (),
) -> tuple[Role, ...]:
    """(N + 1) roles of knots, by which feet stand in a phase and by its intervals; see `Layout`.

    `places`: of each phase the feet's places before and after; () of no phase.
    """
    roles: list[Role] = []
    last_phase = len(stands) - 1
    flights = [p for p, row in enumerate(stands) if not any(row)]
    last_flight = max(flights, default=-1)
    shifts = under_way and bool(flights)
    # Of phases in which less than asked may be done.
    first_swing = next((p for p, r in enumerate(stands) if places and not all(r)), last_phase + 2)
    same: dict[str, Any] = {"under_way": under_way, "moves_arms": moves_arms, "shifts": shifts}
    for p, count in enumerate(intervals):
        before, now, after = np.array(stands)[[max(p - 1, 0), p, min(p + 1, last_phase)]]
        here = {**same, **_placed(places[p] if places else ((), ()), p >= first_swing)}
        for k in range(count):
            first, last = k == 0, k == count - 1
            legs = _legs_by_role(before if first else now, now, after if last else now)
            roles.append(
                Role(
                    phase=p,
                    intervals=count,
                    at_edge=_at_edge(legs, turns),
                    initial=p == 0 and first,
                    first=first,
                    last=last,
                    final=p == last_phase,
                    clears=clears and not (p == 0 and first),
                    leans=turns and p < last_flight,
                    lands_upright=turns and p == last_phase,
                    limits_apex=apex and first and p in flights,
                    shifted=shifts and p > flights[0],
                    chooses_shortfall=last and p == first_swing - 1,
                    **legs,
                    **here,
                )
            )
    end = Role(
        last_phase,
        intervals[-1],
        standing=tuple(range(len(stands[0]))),
        swinging=(),
        terminal=True,
        final=True,
        shifted=shifts,
        **here,
    )
    return (*roles, end)


def _legs_by_role(before: BoolArray, now: BoolArray, after: BoolArray) -> dict[str, Any]:
    """Legs by what they do, of which stand before, at and after a knot."""
    return {
        "standing": _legs(now),
        "swinging": _legs(~now),
        "leaving": _legs(before & ~now),
        "landing": _legs(~before & now),
        "lifting_off": _legs(now & ~after),
        "touching_down": _legs(~now & after),
    }


def _at_edge(legs: dict[str, Any], turns: bool) -> tuple[int, ...]:
    return tuple(sorted({*legs["lifting_off"], *(() if turns else legs["landing"])}))


def _placed(places: tuple[tuple[int, ...], tuple[int, ...]], known: bool) -> dict[str, Any]:
    before, after = places
    return {"places_before": before, "places_after": after, "has_shortfall": known}


def _legs(mask: BoolArray) -> tuple[int, ...]:
    return tuple(int(leg) for leg in np.flatnonzero(mask))
