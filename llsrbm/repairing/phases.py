"""Contact phases of any motion, whoever made it: they are told from how its feet move.

A foot that stays where it is for a while stands there; how long follows from its height, which is
that of the place from when it has come down until it leaves. Heights are crossed between frames,
not at them. Motions of which each frame is a little wrong, or that float or sink, have places all
the same: what counts is how far a foot is from where it stood, not from the ground.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np

from llsrbm.arrays import Array, stretches
from llsrbm.motion.whole_body import WholeBodyMotion

STILL_FOR = 0.2  # s for which a foot stays where it is that stands; at the top of a flight it moves
STILL = 0.006  # m, standard deviation of its places over that time
# m by which a foot is off where it stands as it leaves and as it comes. With it and the CoM's fall,
# edges of flights of 12 simulated jumps of Go2, ANYmal and G1 are at most 17 ms off, at 30, 50 and
# 100 frames/s, with joints that are off by 0.01 rad and without.
OFF = 0.006
SAME = 0.03  # m that a foot slips where it stands
NOISE = 2.0  # standard deviations of what each frame is off by that count as being off
NOISIEST = 0.03  # m by which each frame is off, at most, of a foot that may be seen to stand
OFF_FALL = 0.001  # m by which a CoM is off the parabola of a flight that has ended
INSIDE = 0.15  # of a flight at each end, which that parabola is not fitted to
APART = 0.08  # s, at most, by which feet and CoM count as apart
LIFTS = 0.01  # s, at most, for which a foot has been leaving that is so far off
BRIEF = 0.02  # s of a phase that is none
TOGETHER = 0.05  # s within which feet leave, or land, together: simulated feet land 12 ms apart


class Stance(NamedTuple):
    """A foot that stands: when, s, and where, (3,) m, the median of its contact point's places."""

    start: float
    end: float
    place: Array


@dataclass(frozen=True)
class ContactPhase:
    """A stretch of a motion in which the same feet stand.

    `name`: "flight", or which feet stand; feet: names of legs; start_s, end_s: s of its own time.
    """

    name: str
    feet: tuple[str, ...]
    start_s: float
    end_s: float

    def as_dict(self) -> dict[str, Any]:
        """As JSON has it."""
        return vars(self) | {"feet": list(self.feet)}


def contact_phases(motion: WholeBodyMotion) -> tuple[ContactPhase, ...]:
    """The phases of a whole motion, in order, from its first frame to its last.

    Feet that leave, or land, within `TOGETHER` do so together: when the last one leaves, when the
    first one lands. A flight's edges are halfway between what its feet say and what its CoM says.
    """
    names, time = motion.robot.leg_names, motion.time
    stood = [stances(motion, foot) for foot in range(len(names))]
    on = np.array([bool(row) and row[0].start <= time[0] for row in stood])
    start, found = float(time[0]), []
    for at, changed in (*_changes(stood, time), (float(time[-1]), ())):
        feet = tuple(name for name, stands in zip(names, on, strict=True) if stands)
        found.append(ContactPhase(phase_name(feet, len(names)), feet, start, at))
        on[list(changed)] ^= True
        start = at
    return tuple(_with_falls(list(_joined(found)), motion))


def _with_falls(phases: list[ContactPhase], motion: WholeBodyMotion) -> list[ContactPhase]:
    """The phases with their flights' edges as feet and CoM have them together.

    Feet are seen to have left after they have, the CoM to fall before it does.
    """
    for k, phase in enumerate(phases):
        if phase.feet or k in (0, len(phases) - 1):
            continue
        start, end = phase.start_s, phase.end_s
        falls = _fall(motion.time, motion.com[:, 2], start, end)
        start, end = (
            feet + float(np.clip(com - feet, -APART, APART)) / 2
            for feet, com in zip((start, end), falls, strict=True)
        )
        before, after = phases[k - 1], phases[k + 1]
        if before.start_s < start < end < after.end_s:
            phases[k - 1] = replace(before, end_s=start)
            phases[k] = replace(phase, start_s=start, end_s=end)
            phases[k + 1] = replace(after, start_s=end)
    return phases


def _fall(time: Array, height: Array, start: float, end: float) -> tuple[float, float]:
    """From when to when, s, a CoM is on the parabola on which it is within a flight."""
    long = end - start
    for share in (INSIDE, 0.0):
        inside = np.flatnonzero((time > start + share * long) & (time < end - share * long))
        if len(inside) >= 4:
            break
    else:
        return start, end
    curve = np.polyfit(time[inside] - start, height[inside], 2)
    away = np.abs(height - np.polyval(curve, time - start))
    off = OFF_FALL + 3 * noise(height)
    first, last = int(inside[0]), int(inside[-1])
    return _crossing(time, away, off, first, -1), _crossing(time, away, off, last, 1)


def _joined(phases: list[ContactPhase]) -> Iterator[ContactPhase]:
    """Without those that hardly last, and with one for neighbours on the same feet."""
    lasting: list[ContactPhase] = []
    for phase in phases:
        if phase.end_s - phase.start_s >= BRIEF:
            start = lasting[-1].end_s if lasting else phases[0].start_s
            lasting.append(replace(phase, start_s=start))
    if lasting:
        lasting[-1] = replace(lasting[-1], end_s=phases[-1].end_s)
    for _, alike in groupby(lasting, key=lambda phase: phase.feet):
        first, *others = alike
        yield replace(first, end_s=others[-1].end_s) if others else first


def _changes(stood: list[list[Stance]], time: Array) -> Iterator[tuple[float, tuple[int, ...]]]:
    """When feet leave or land, s in order, and which."""
    events = [
        (at, lands, foot)
        for foot, row in enumerate(stood)
        for stance in row
        for at, lands in ((stance.start, True), (stance.end, False))
        if time[0] < at < time[-1]
    ]
    together: list[tuple[float, bool, int]] = []
    for event in sorted(events):
        if together and (event[1] != together[0][1] or event[0] - together[0][0] > TOGETHER):
            yield _at_once(together)
            together = []
        together.append(event)
    if together:
        yield _at_once(together)


def _at_once(events: list[tuple[float, bool, int]]) -> tuple[float, tuple[int, ...]]:
    at = events[0][0] if events[0][1] else events[-1][0]
    return at, tuple(foot for *_, foot in events)


def phase_name(feet: tuple[str, ...], legs: int) -> str:
    """The name of a phase in which so many `legs`' feet stand, by which they are."""
    if not feet:
        return "flight"
    return "all feet stand" if len(feet) == legs else f"{', '.join(feet)} stand"


def stances(motion: WholeBodyMotion, foot: int) -> list[Stance]:
    """When and where a foot stands, in order."""
    time, place = motion.time, motion.foot_position[:, foot]
    off = OFF + NOISE * noise(place[:, 2])
    found: list[Stance] = []
    for first, end in _still(time, place):
        # It is still until it has moved, so it has begun to at the end of that.
        half = max((_last_within(time, first) - first) // 2, 0)
        inside = slice(first + half, max(end - half, first + half + 1))
        at = np.median(place[inside], axis=0)
        came = np.abs(place[:, 2] - np.median(place[inside][: 2 * half + 1, 2]))
        leaves = np.abs(place[:, 2] - np.median(place[inside][-2 * half - 1 :, 2]))
        start = _crossing(time, came, off, inside.start, -1)
        # It has begun to leave before; by half of this lift-offs of simulated jumps are met.
        stop, higher = (_crossing(time, leaves, k * off, inside.stop - 1, 1) for k in (1, 4))
        if stop < time[-1]:
            stop -= min((higher - stop) / 2, LIFTS)
        if found and start <= found[-1].end:
            last = found[-1]
            if np.linalg.norm(last.place - at) < SAME:
                found[-1] = last._replace(end=max(stop, last.end))
                continue
            start = (start + last.end) / 2  # it has slid there
            found[-1] = last._replace(end=start)
        found.append(Stance(start, stop, at))
    return found


def noise(values: Array) -> float:
    """The standard deviation by which each frame of a smooth quantity (K,) is off.

    By its third differences, which motions hardly have.
    """
    if len(values) < 8:
        return 0.0
    third = np.diff(values, 3)
    return float(np.median(np.abs(third)) / 0.6745 / np.sqrt(20.0))


def _still(time: Array, place: Array) -> list[tuple[int, int]]:
    """[first, end) of frames among which a foot hardly moves for `STILL_FOR`."""
    off = np.minimum([noise(axis) for axis in place.T], NOISIEST)
    spread = np.sqrt(STILL**2 + off**2)
    still = np.zeros(len(time), dtype=np.bool_)
    for k in range(len(time)):
        end = _last_within(time, k) + 1
        if (
            time[end - 1] - time[k] > 0.8 * STILL_FOR
            and (np.std(place[k:end], axis=0) < spread).all()
        ):
            still[k:end] = True
    return stretches(still)


def _last_within(time: Array, k: int) -> int:
    """The last frame within `STILL_FOR` after one."""
    return int(np.searchsorted(time, time[k] + STILL_FOR + 1e-9)) - 1


def _crossing(time: Array, away: Array, off: float, at: int, step: int) -> float:
    """When, going on from a frame, a foot is first off its place, s; the motion's end if never."""
    # A single frame that is off is wrong.
    while (
        0 <= at + step < len(time) and away[[at + step, _within(at + 2 * step, time)]].min() <= off
    ):
        at += step
    if not 0 <= at + step < len(time):
        return float(time[at])
    here, there = away[at], away[at + step]
    share = (off - here) / max(there - here, 1e-12)
    return float(time[at] + np.clip(share, 0.0, 1.0) * (time[at + step] - time[at]))


def _within(at: int, time: Array) -> int:
    return min(max(at, 0), len(time) - 1)
