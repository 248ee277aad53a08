"""Counts of outcomes that published tables are made of.

An outcome is an `Outcome`, or a mapping of its figures; a request that was not planned has none of
them.
"""

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from llsrbm.motion.outcome import Outcome


class Counts(NamedTuple):
    """Requests, and those planned, that stand at the end, are strict, recovered."""

    requests: int
    planned: int
    stand: int
    strict: int
    recovered: int


def count(rows: Iterable[Outcome | Mapping[str, Any]]) -> Counts:
    """Count outcomes; rows with `planned` False have no outcome."""
    every = [row if isinstance(row, Mapping) else vars(row) for row in rows]
    planned = [row for row in every if row.get("planned", True)]
    return Counts(
        requests=len(every),
        planned=len(planned),
        stand=sum(row["status"] == "landed" for row in planned),
        strict=sum(row["strict"] is True for row in planned),
        recovered=sum(row["recovered"] is True for row in planned),
    )


def seeds_of(text: str) -> range:
    """The seeds "first:last+1"."""
    first, last = (int(part) for part in text.split(":"))
    return range(first, last)


def write_lines(path: Path, results: Iterable[Mapping[str, Any]]) -> None:
    """Write results as JSON lines."""
    text = "".join(json.dumps(result) + "\n" for result in results)
    path.write_text(text, encoding="utf-8")
