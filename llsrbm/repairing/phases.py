"""Contact phases of any motion, read from how its feet and its CoM move.

A foot that stays where it is for a while stands there; how long follows from its height, which is
that of the place from when it has come down until it leaves. Where no foot stays where it is the
CoM tells whether the robot flies; if it does not, the lowest feet stand, though they slide.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any

import numpy as np

from llsrbm.arrays import Array
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.repairing.falls import fall_edges, flights_within, standing
from llsrbm.repairing.stances import Stance, stances

APART = 0.08  # s, at most, by which feet and CoM count as apart
BRIEF = 0.02  # s of a phase that is none
TOGETHER = 0.05  # s within which feet leave, or land, together: simulated feet land 12 ms apart


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
    by_feet = list(_joined(found))
    checked = list(_checked_by_falls(by_feet, motion))
    if _flown(by_feet) - _flown(checked) > APART:
        # Its feet slide as they stand: those that are as low as others stand like them.
        checked = [part for phase in checked for part in _lowest_of(phase, motion)]
    return tuple(_with_falls(list(_joined(checked)), motion))


def _flown(phases: list[ContactPhase]) -> float:
    return sum(phase.end_s - phase.start_s for phase in phases if not phase.feet)


def _lowest_of(phase: ContactPhase, motion: WholeBodyMotion) -> Iterator[ContactPhase]:
    if phase.feet and len(phase.feet) < len(motion.robot.legs):
        yield from _on_the_lowest(motion, phase.start_s, phase.end_s)
    else:
        yield phase


def _checked_by_falls(
    phases: list[ContactPhase], motion: WholeBodyMotion
) -> Iterator[ContactPhase]:
    """The phases with those without feet as the CoM shows them."""
    for phase in phases:
        if phase.feet:
            yield phase
            continue
        at = phase.start_s
        for start, end in (*flights_within(motion, phase.start_s, phase.end_s), (phase.end_s,) * 2):
            yield from _on_the_lowest(motion, at, start)
            if end > start:
                yield replace(phase, start_s=start, end_s=end)
            at = end


def _on_the_lowest(motion: WholeBodyMotion, start: float, end: float) -> Iterator[ContactPhase]:
    if end <= start:
        return
    names = motion.robot.leg_names
    found = standing(motion, start, end)
    for (at, on), until in zip(found, [*(since for since, _ in found[1:]), end], strict=True):
        feet = tuple(name for name, stands in zip(names, on, strict=True) if stands)
        yield ContactPhase(phase_name(feet, len(names)), feet, at, until)


def _with_falls(phases: list[ContactPhase], motion: WholeBodyMotion) -> list[ContactPhase]:
    """The phases with their flights' edges as feet and CoM have them together.

    Feet are seen to have left after they have, the CoM to fall before it does.
    """
    for k, phase in enumerate(phases):
        if phase.feet or k in (0, len(phases) - 1):
            continue
        start, end = phase.start_s, phase.end_s
        falls = fall_edges(motion.time, motion.com[:, 2], start, end)
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
