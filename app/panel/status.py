"""The status line: one of the contract's words, and what follows it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Word(StrEnum):
    """With which a status line begins."""

    PLANNING = "Planning"
    PLANNED = "Planned"
    SIMULATING = "Simulating"
    LANDED = "Landed"
    FELL = "Fell"
    FAILED = "Failed"
    CANCELLED = "Cancelled"


@dataclass(frozen=True)
class Status:
    """How it goes.

    Attributes:
        word: with which the line begins.
        rest: what follows.
        busy: whether there is something to cancel.
        share: of it that is done, 0 to 1; None where that is not known.
    """

    word: Word
    rest: str
    busy: bool = False
    share: float | None = None
