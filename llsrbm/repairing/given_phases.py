"""Contact phases that a person gives in place of those that are found: read and checked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

from llsrbm.errors import InputError
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.repairing.phases import BRIEF, ContactPhase, phase_name
from llsrbm.request.messages import check_kind
from llsrbm.text_files import parse_json, read_text

Given = str | Path | Sequence[ContactPhase]

_WHAT = 'a list of phases, as `llsrbm repair --json` prints it under "phases"'
_KEYS = {"feet", "start_s", "end_s"}  # and, for people, "name"
_LARGEST = 1024**2  # bytes
_SAME = 1e-3  # s by which times may be rounded


def given_phases(given: Given, motion: WholeBodyMotion) -> tuple[ContactPhase, ...]:
    """The phases in a JSON file or a sequence, as those of a motion, or of a stretch of it.

    Their names follow from their feet. Times are made to meet that are off by a thousandth of a
    second.

    Raises:
        InputError: unreadable, or no such list; feet that the robot has not; times that are out of
            order or outside the motion; no flight between phases on all feet.
    """
    check_kind("phases", given, str | Path | Sequence, f"{_WHAT}, or its file")
    where = str(given) if isinstance(given, str | Path) else "phases"
    phases = _read(Path(given), where) if isinstance(given, str | Path) else list(given)
    legs, end = motion.robot.leg_names, float(motion.time[-1])
    found: list[ContactPhase] = []
    for number, phase in enumerate(phases, start=1):
        try:
            found.append(_checked(phase, found[-1] if found else None, legs, end))
        except InputError as error:
            raise InputError(f"{where}: phase {number}: {error}") from None
    _check_flights(found, len(legs), where)
    return tuple(found)


def _read(path: Path, where: str) -> list[ContactPhase]:
    table = parse_json(read_text(path, _WHAT, _LARGEST), where)
    if isinstance(table, dict) and "phases" in table:
        table = table["phases"]
    if not isinstance(table, list):
        raise InputError(f"{where}: expected {_WHAT}")
    return [_phase(row, f"{where}: phase {number}") for number, row in enumerate(table, start=1)]


def _phase(row: Any, where: str) -> ContactPhase:
    keys = set(row) if isinstance(row, dict) else set()
    if not _KEYS <= keys <= _KEYS | {"name"}:
        listed = ", ".join(map(str, row)) if isinstance(row, dict) else type(row).__name__
        raise InputError(f"{where}: expected name, feet, start_s and end_s, got {listed:.100}")
    feet = row["feet"]
    if not isinstance(feet, list) or not all(isinstance(foot, str) for foot in feet):
        raise InputError(
            f"{where}: feet: expected a list of names, [] in a flight, got {feet!r:.60}"
        )
    times = row["start_s"], row["end_s"]
    for key, time in zip(("start_s", "end_s"), times, strict=True):
        if isinstance(time, bool) or not isinstance(time, int | float) or not math.isfinite(time):
            raise InputError(f"{where}: {key}: expected a number, s, got {time!r:.60}")
    return ContactPhase("", tuple(feet), float(times[0]), float(times[1]))


def _checked(
    phase: ContactPhase, before: ContactPhase | None, legs: tuple[str, ...], end: float
) -> ContactPhase:
    """A phase with its feet in the robot's order, from where the one before it ends."""
    if not isinstance(phase, ContactPhase):
        raise InputError(f"expected one of `Repair.phases`, got {type(phase).__name__}")
    for foot in phase.feet:
        if foot not in legs:
            raise InputError(
                f'no foot "{foot:.40}"; expected {", ".join(legs)}, or none in a flight'
            )
    feet = tuple(leg for leg in legs if leg in phase.feet)
    start, stop = phase.start_s, phase.end_s
    for key, time in (("start_s", start), ("end_s", stop)):
        if not -_SAME <= time <= end + _SAME:
            raise InputError(f"{key} {time:g}: expected 0 to {end:.3f} s, the motion's own time")
    if stop - start < BRIEF:
        raise InputError(f"end_s {stop:g}: expected {BRIEF:g} s or more after start_s, {start:g} s")
    if before is not None:
        if abs(start - before.end_s) > _SAME:
            raise InputError(
                f"start_s {start:g}: expected {before.end_s:g} s, where the phase before it ends"
            )
        if feet == before.feet:
            raise InputError("has the feet of the phase before it; expected others, or one phase")
        start = before.end_s
    name = phase_name(feet, len(legs))
    return replace(phase, name=name, feet=feet, start_s=max(start, 0.0), end_s=min(stop, end))


def _check_flights(phases: list[ContactPhase], legs: int, where: str) -> None:
    flights = [k for k, phase in enumerate(phases) if not phase.feet]
    if not flights:
        raise InputError(f"{where}: no phase is a flight; expected at least one with feet []")
    stood = [k for k, phase in enumerate(phases) if len(phase.feet) == legs]
    if not any(any(first < k < last for k in flights) for first, last in pairwise(stood)):
        raise InputError(f"{where}: no flight is between two phases on all feet; expected one")
