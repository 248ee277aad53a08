"""The part of a motion that is a jump, or several in a row: from rest to rest, on all feet."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby, pairwise

import numpy as np

from llsrbm.arrays import Array
from llsrbm.errors import Error
from llsrbm.mechanics import GRAVITY, tilt
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.repairing.feet import feet_of
from llsrbm.repairing.phases import ContactPhase, phase_name

SHORT = 0.2  # s: what is shorter beside a flight may be done on all feet
LOOKED_AT = 0.15  # s for which feet are looked at where they stand
# m that the middle of all feet moves in a phase of feet that slide; balls that roll move by 0.02.
SLIDES = 0.04
REBOUND = 1.4  # s for which a robot stands, at most, between jumps in a row
SOONEST, LATEST = 0.25, 0.9  # s from where a robot is at rest to lift-off, or from touchdown
AT_REST = 0.005  # m that the CoM moves, at most, in `REST_FOR` (s) of a robot at rest
REST_FOR = 0.2
UPSIDE_DOWN = 2.0  # rad
FAST, SLOW = 0.5, 2.0  # times as long as gravity takes that flights are believed to take


class NoJump(Error):
    """A motion without a jump that could be repaired; the message is one sentence."""


@dataclass(frozen=True, eq=False)
class Part:
    """A stretch of a motion with its contact phases, which begin and end on all feet.

    Attributes:
        motion: all of it.
        phases: of the stretch; places: (P,) how many flights were before each.
        slower: how many times as long its flights take as gravity lets them.
        merged: names of phases on some feet that are taken for ones on all.
    """

    motion: WholeBodyMotion
    phases: tuple[ContactPhase, ...]
    slower: float
    merged: tuple[str, ...] = ()

    @property
    def edges(self) -> Array:
        """(P + 1,) s of the motion's time."""
        return np.array([*(phase.start_s for phase in self.phases), self.phases[-1].end_s])

    @property
    def feet(self) -> tuple[tuple[str, ...], ...]:
        """(P,) names of the legs that stand."""
        return tuple(phase.feet for phase in self.phases)

    @property
    def places(self) -> tuple[int, ...]:
        """(P,) how many flights were before."""
        return tuple(int(n) for n in np.cumsum([not feet for feet in self.feet]))

    @property
    def flights(self) -> int:
        """Number of flights."""
        return self.places[-1]

    @property
    def turns_over(self) -> bool:
        """Whether the body does in a flight: it is upside down there."""
        time = self.motion.time
        there = (time >= self.edges[0]) & (time <= self.edges[-1])
        return bool(tilt(self.motion.base_quat[there]).max() > UPSIDE_DOWN)

    def footholds(self) -> Array:
        """(flights + 1, L, 3) m, file's frame: where the feet stand in each place, as a plan's do.

        Balls roll as legs bend: at the ends it is where they stand at rest, else where they land.
        Feet that slide stand where they leave the ground, or where they meet it.
        """
        own, (first, last) = self.places, self.slides
        at = [self.edges[0], *(self.edges[own.index(k) + 1] for k in range(1, self.flights))]
        at.append(self.edges[-1] - LOOKED_AT)
        lasts = [LOOKED_AT] * len(at)
        if first:
            at[0], lasts[0] = self.edges[1], 0.0
        if last:
            at[-1], lasts[-1] = self.edges[-2], 0.0
        return np.array([self._feet(*each) for each in zip(at, lasts, strict=True)])

    @cached_property
    def slides(self) -> tuple[bool, bool]:
        """Whether the feet slide before they leave the ground for the first time, all of them, and
        after they have met it for the last time.
        """
        start, lifts, lands, end = (
            self._feet(at, 0.0).mean(axis=0)[:2] for at in self.edges[[0, 1, -2, -1]]
        )
        first, last = np.linalg.norm([lifts - start, end - lands], axis=1) > SLIDES
        return bool(first), bool(last)

    def _feet(self, start: float, lasts: float) -> Array:
        """(L, 3) m: the median of the feet's places in so long, or at the frame nearest to it."""
        time = self.motion.time
        there = (time >= start - 1e-9) & (time <= start + lasts + 1e-9)
        if not there.any():
            there = np.abs(time - start) == np.abs(time - start).min()
        places, _ = feet_of(self.motion.robot, self.motion.qpos[there])
        found: Array = np.median(places, axis=0)
        return found


def parts(motion: WholeBodyMotion, phases: tuple[ContactPhase, ...]) -> list[Part]:
    """The jumps of a motion, in order, those that follow each other at once together.

    `phases`: its contact phases, or those of a stretch of it.

    Raises:
        NoJump: there is none that begins and ends on all feet.
    """
    if not any(phase.feet for phase in phases):
        raise NoJump("no foot stays in its place anywhere for as long as feet that stand do")
    legs = len(motion.robot.legs)
    phases = tuple(_without_taps(phases, motion.robot.leg_names))
    stood = [k for k, phase in enumerate(phases) if len(phase.feet) == legs]
    if not any(not phase.feet for phase in phases):
        raise NoJump("no foot leaves the ground for a flight of all feet")
    found: list[tuple[int, int]] = []
    for first, last in pairwise(stood):
        if all(phase.feet for phase in phases[first:last]):
            continue
        if (
            found
            and found[-1][1] == first
            and phases[first].end_s - phases[first].start_s < REBOUND
        ):
            first, last = found.pop()[0], last
        found.append((first, last))
    if not found:
        raise NoJump("no flight begins and ends with all feet on the ground")
    rows = [phases[first : last + 1] for first, last in found]
    return [_at_rest(Part(motion, row, _slower(motion, row))) for row in rows]


def _without_taps(
    phases: tuple[ContactPhase, ...], legs: tuple[str, ...]
) -> Iterator[ContactPhase]:
    """The phases, with all feet where some hardly leave between two phases on all."""
    taken: list[ContactPhase] = []
    for k, phase in enumerate(phases):
        beside = phases[max(k - 1, 0)].feet, phases[min(k + 1, len(phases) - 1)].feet
        if phase.feet and beside == (legs, legs) and phase.end_s - phase.start_s <= SHORT:
            phase = replace(phase, feet=legs, name=phase_name(legs, len(legs)))
        taken.append(phase)
    for _, alike in groupby(taken, key=lambda phase: phase.feet):
        first, *others = alike
        yield replace(first, end_s=others[-1].end_s) if others else first


def merged(part: Part) -> Part:
    """The part with what is short beside flights on all feet, as jumps of the default type are."""
    names = part.motion.robot.leg_names
    found: list[ContactPhase] = []
    dropped = []
    for phase in part.phases:
        if phase.feet and len(phase.feet) < len(names) and phase.end_s - phase.start_s <= SHORT:
            dropped.append(phase.name)
            phase = replace(phase, feet=names, name="all feet stand")
        if found and found[-1].feet == phase.feet:
            found[-1] = replace(found[-1], end_s=phase.end_s)
        else:
            found.append(phase)
    return replace(part, phases=tuple(found), merged=tuple(dropped))


def _at_rest(part: Part) -> Part:
    """The part from where the robot was last at rest before, to where it first is after."""
    first, *inner, last = part.phases
    time, com = part.motion.time, part.motion.com
    nearest, farthest = SOONEST * part.slower, LATEST * part.slower
    before = (time >= first.start_s) & (time <= first.end_s)
    after = (time >= last.start_s) & (time <= last.end_s)
    start = first.end_s - _rest(
        first.end_s - time[before][::-1], com[before][::-1], nearest, farthest
    )
    end = last.start_s + _rest(time[after] - last.start_s, com[after], nearest, farthest)
    ends = replace(first, start_s=start), replace(last, end_s=end)
    return replace(part, phases=(ends[0], *inner, ends[1]))


def _rest(since: Array, com: Array, nearest: float, farthest: float) -> float:
    """After how long, s, a CoM (K, 3) m at increasing times (K,) s is at rest.

    Where the motion ends before it is: at its end; where it never is: as late as may be.
    """
    if not len(since) or since[-1] - nearest < REST_FOR:
        return float(since[-1]) if len(since) else nearest
    for k in np.flatnonzero(since >= nearest):
        stays = com[(since >= since[k]) & (since <= since[k] + REST_FOR)]
        if (np.ptp(stays, axis=0) < AT_REST).all():
            late = float(since[k]) + REST_FOR / 2
            return min(float(since[-1]) if since[-1] - late < REST_FOR else late, farthest)
    return min(float(since[-1]), farthest)


def _slower(motion: WholeBodyMotion, phases: tuple[ContactPhase, ...]) -> float:
    """How many times as long flights take as gravity lets them, by the CoM's curve in them."""
    time, found = motion.time, []
    for phase in phases:
        if phase.feet:
            continue
        inner = 0.1 * (phase.end_s - phase.start_s)
        there = (time >= phase.start_s + inner) & (time <= phase.end_s - inner)
        if there.sum() < 4:
            continue
        falls = -2 * np.polyfit(time[there] - phase.start_s, motion.com[there, 2], 2)[0]
        found.append(np.sqrt(GRAVITY / max(falls, 1e-3)))
    return float(np.clip(np.median(found), FAST, SLOW)) if found else 1.0
