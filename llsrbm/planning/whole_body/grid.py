"""Knots of the whole-body problem, and when they are.

Accelerations, forces and torques are straight lines over an interval, given by their values in the
middles of its halves (`NODES`), where the equations of motion hold. So a plan with a knot at each
half has in the middle of each of its intervals exactly these.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from llsrbm.motion.plan import Plan
from llsrbm.request.schedule import Schedule

Array = NDArray[np.float64]

SAME_INSTANT = 1e-9  # s
# From 0, even intervals, to 1. On the ground the equations of motion miss least between the nodes
# from 0.6 to 0.75: a fifth to two fifths of what they miss with even ones. In flight they miss most
# in its middle, or right before touchdown: there ANYmal's twists of 85 to 130 degrees miss 0.11 of
# its weight with 0.3, and 0.09 with 0.42. A half more intervals in flight make the harder
# jumps of three robots ones that are found and hold: with as many as on the ground legs that
# outweigh a trunk miss up to 55 % of the weight.
DENSER, DENSER_IN_FLIGHT = 0.65, 0.42
FINER_IN_FLIGHT = 1.5
FEWEST = 2  # intervals of a phase
_DIGITS = 9  # of a density that is read from knots


@dataclass(frozen=True)
class Knot:
    """A knot's place in the schedule.

    Attributes:
        standing: legs whose feet stand over the interval from there; none at the end.
        resting: legs whose feet stand before or after; landing: those that meet the ground there.
    """

    standing: tuple[int, ...]
    resting: tuple[int, ...]
    landing: tuple[int, ...]
    first: bool
    last: bool


@dataclass(frozen=True)
class Grid:
    """Phases in order: the legs whose feet stand, and the number of intervals.

    Attributes:
        denser_in_flight: how much denser intervals of a flight are beside its edges; 0: even.
    """

    phases: tuple[tuple[tuple[int, ...], int], ...]
    denser_in_flight: float = DENSER_IN_FLIGHT

    @classmethod
    def of(cls, plan: Plan, finer: float = 1.0) -> Grid:
        """The grid that a draft is refined on, or one like a refined plan's; or one with `finer`
        times as many intervals.
        """
        counts = np.bincount(plan.phase[:-1], minlength=len(plan.schedule)).astype(np.float64)
        return cls._with(plan.schedule, finer * counts, 1.0 if plan.refined else FINER_IN_FLIGHT)

    @classmethod
    def under(cls, plan: Plan) -> Grid:
        """The grid that a refined plan is of: its flights are as dense as the plan's knots are."""
        even, dense = (replace(cls.of(plan), denser_in_flight=denser) for denser in (0.0, 1.0))
        lowest, highest = even.times(plan.phase_start), dense.times(plan.phase_start)
        flights, moved = ~even.stood, highest - lowest
        of_all = float(np.sum(moved[flights] ** 2))
        if of_all == 0.0:  # no flight, or none with a knot in it that could be elsewhere
            return cls.of(plan)
        along = float(np.sum((plan.time - lowest)[flights] * moved[flights]))
        return replace(even, denser_in_flight=round(along / of_all, _DIGITS))

    @classmethod
    def at(cls, schedule: Schedule, counts: Sequence[int]) -> Grid:
        """The grid that a draft of a schedule with so many intervals a phase is refined on."""
        return cls._with(schedule, np.array(counts, dtype=np.float64), FINER_IN_FLIGHT)

    @classmethod
    def _with(cls, schedule: Schedule, counts: Array, finer: float) -> Grid:
        stands = [tuple(np.flatnonzero(legs).tolist()) for legs in schedule.stands]
        shares = [1.0 if legs else finer for legs in stands]
        intervals = [
            max(FEWEST, math.ceil(share * count / 2))
            for share, count in zip(shares, counts.tolist(), strict=True)
        ]
        return cls(tuple(zip(stands, intervals, strict=True)))

    @property
    def intervals(self) -> int:
        """Intervals of all phases."""
        return sum(count for _, count in self.phases)

    @cached_property
    def phase(self) -> NDArray[np.int64]:
        """(N,) the phase of each interval."""
        return np.repeat(np.arange(len(self.phases)), [count for _, count in self.phases])

    @cached_property
    def knots(self) -> tuple[Knot, ...]:
        """(N+1,) in order."""
        found: list[Knot] = []
        for number, (standing, count) in enumerate(self.phases):
            before = self.phases[number - 1][0] if number else standing
            for k in range(count):
                beside = before if k == 0 else standing
                found.append(
                    Knot(
                        standing=standing,
                        resting=tuple(sorted({*standing, *beside})),
                        landing=tuple(leg for leg in standing if leg not in beside),
                        first=not found,
                        last=False,
                    )
                )
        return (*found, Knot((), self.phases[-1][0], (), first=False, last=True))

    @cached_property
    def shares(self) -> Array:
        """(2 N + 1,) the knots and the middles between them: phases before, and share of the own.

        Intervals are shorter beside the phases' edges, where legs start and stop.
        """
        parts = []
        for number, (standing, count) in enumerate(self.phases):
            denser = DENSER if standing else self.denser_in_flight
            # A quarter of a wave where the motion begins or ends at rest, else half of one.
            first, last = number > 0, number + 1 < len(self.phases)
            wave = np.cos(
                np.pi * np.linspace(0.0 if first else 0.5, 1.0 if last else 0.5, count + 1)
            )
            even = np.linspace(0.0, 1.0, count + 1)
            dense = (wave - wave[0]) / (wave[-1] - wave[0]) if first or last else even
            knots = number + (1 - denser) * even + denser * dense
            middles = (knots[1:] + knots[:-1]) / 2
            parts.append(np.column_stack([knots[:-1], middles]).ravel())
        return np.append(np.concatenate(parts), float(len(self.phases)))

    def times(self, phase_start: Array) -> Array:
        """(2 N + 1,) s: the knots and the middles between them, of (P + 1,) s phases' edges."""
        time: Array = np.interp(self.shares, np.arange(len(phase_start)), phase_start)
        return time

    def phase_at(self, half: int) -> int:
        """The phase in which a knot, or a middle after one, is; the later one at its edge."""
        return min(int(self.shares[half]), len(self.phases) - 1)

    @cached_property
    def last_landing(self) -> int:
        """The first phase after the last flight; none of a schedule that has no flight."""
        flights = [number for number, (legs, _) in enumerate(self.phases) if not legs]
        return flights[-1] + 1 if flights else len(self.phases)

    @cached_property
    def landed(self) -> NDArray[np.bool_]:
        """(2 N + 1,) where legs stand after a flight."""
        stands = np.array([bool(legs) for legs, _ in self.phases])
        return self._at_halves(stands & (np.cumsum(~stands) > 0))

    @cached_property
    def stood(self) -> NDArray[np.bool_]:
        """(2 N + 1,) where legs stand."""
        return self._at_halves(np.array([bool(legs) for legs, _ in self.phases]))

    def _at_halves(self, of_phases: NDArray[np.bool_]) -> NDArray[np.bool_]:
        found: NDArray[np.bool_] = of_phases[
            [self.phase_at(half) for half in range(len(self.shares))]
        ]
        return found

    @property
    def name(self) -> str:
        """For the cache."""
        return "-".join(
            f"{''.join(map(str, legs)) or 'air'}x{count}" for legs, count in self.phases
        )
