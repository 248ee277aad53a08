"""The card of a whole library: how many motions of what, ranges, checks, simulations, checksums."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import fields
from typing import Any

from llsrbm.files.atomic import staged
from llsrbm.installed import package_version
from llsrbm.library.card import Card, Figures
from llsrbm.library.file import as_text
from llsrbm.library.library import Library
from llsrbm.number_text import aligned

CARD, README = "card.json", "README.md"
SCHEMA = "llsrbm.library-card/1"
LICENCE = "BSD-3-Clause"

_README = """\
# A library of certified motions

{count} motions of {robots} robots, made by llsrbm {version}. Each is a plan of the whole body's
equations of motion whose certificate holds at 1 kHz (stops, speeds, torques, friction, slip,
distances, dynamics); {simulated}. Simulations have
everything disturbed: the trunk's mass, friction, contacts, delays, what is measured. Builds
keep motions alone that are strict in each, so that this share is no forecast; some motions, such
as flips, are added as they are.

{table}

    llsrbm library --dir DIR                       # lists them
    llsrbm library export NAME --dir DIR --format motion-npz --out FILE.npz

`card.json` has the counts, the ranges and the SHA-256 of each file. Licence: {licence}; robots' own
descriptions have theirs.
"""


def describe(library: Library) -> dict[str, Any]:
    """The card of a library as plain data: SI units, radians.

    `robots` and `kinds`: motions of each; `ranges`: least and largest of each figure; `checks`: how
    many motions hold each, and the least and the largest of their worst values; `files`: name,
    bytes and SHA-256.
    """
    cards = library.cards
    return {
        "schema": SCHEMA,
        "package_version": package_version(),
        "licence": LICENCE,
        "motions": len(cards),
        "robots": {
            robot: {"motions": len(own), "kinds": _counts(card.kind for card in own)}
            for robot, own in _grouped(cards, lambda card: card.robot).items()
        },
        "kinds": _counts(card.kind for card in cards),
        "ranges": _ranges(cards),
        "certified": sum(card.certified for card in cards),
        "checks": _worst(cards),
        "simulations": {
            name: sum(getattr(card.simulated, name) for card in cards)
            for name in ("seeds", "landed", "strict")
        },
        "files": [
            {
                "name": path.relative_to(library.folder).as_posix(),
                "bytes": path.stat().st_size,
                "sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
            }
            for path in library.files
        ],
    }


def write_description(library: Library) -> dict[str, Any]:
    """Write `card.json` and `README.md` into a library's folder; gives what the card says.

    Raises `InputError`: they cannot be written.
    """
    found = describe(library)
    for name, text in ((CARD, as_text(found)), (README, _readme(found))):
        with staged(library.folder / name) as draft:
            draft.write_text(text, encoding="utf-8")
    return found


def _readme(found: dict[str, Any]) -> str:
    kinds = list(found["kinds"])
    rows = [["| robot", *(f"| {kind}" for kind in kinds), "| all |"]]
    rows.append(["|---"] * (len(kinds) + 1) + ["|---|"])
    for robot, own in found["robots"].items():
        counts = [f"| {own['kinds'].get(kind, 0)}" for kind in kinds]
        rows.append([f"| {robot}", *counts, f"| {own['motions']} |"])
    done = found["simulations"]
    simulated = f"{done['strict']} of {done['seeds']} simulations landed strictly"
    return _README.format(
        count=found["motions"],
        robots=len(found["robots"]),
        version=found["package_version"],
        simulated=simulated if done["seeds"] else "none was simulated",
        table="\n".join(aligned(rows)),
        licence=found["licence"],
    )


def _grouped(cards: Iterable[Card], key: Callable[[Card], str]) -> dict[str, list[Card]]:
    groups: dict[str, list[Card]] = {}
    for card in cards:
        groups.setdefault(key(card), []).append(card)
    return dict(sorted(groups.items()))


def _counts(values: Iterable[str]) -> dict[str, int]:
    return dict(sorted(Counter(values).items()))


def _ranges(cards: Sequence[Card]) -> dict[str, list[float]]:
    """Name of a figure -> its least and its largest value."""
    found = {}
    for name in (field.name for field in fields(Figures)):
        values = [getattr(card.figures, name) for card in cards]
        found[name] = [min(values, default=0.0), max(values, default=0.0)]
    return found


def _worst(cards: Sequence[Card]) -> dict[str, dict[str, Any]]:
    """Check -> how many motions hold it, and the worst values of all: its least and its largest."""
    found: dict[str, dict[str, Any]] = {}
    for card in cards:
        for name, finding in card.certificate.items():
            entry = found.setdefault(name, {"holds": 0, "least": None, "largest": None})
            entry["holds"] += finding["holds"] is True
            worst = finding["worst"]
            if worst is not None:
                least, largest = entry["least"], entry["largest"]
                entry["least"] = worst if least is None else min(worst, least)
                entry["largest"] = worst if largest is None else max(worst, largest)
    return found
