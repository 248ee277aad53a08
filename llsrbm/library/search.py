"""Motions by words and by figures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Annotated

from llsrbm.library.card import Card
from llsrbm.request.messages import Number, check_fields


@dataclass(frozen=True)
class Filters:
    """Least and largest figures of motions that are looked for; each field states its own."""

    min_distance: Annotated[float, Number("Leads at least so far, horizontally", "M", unit="m")] = (
        0.0
    )
    max_distance: Annotated[float, Number("Leads at most so far", "M", unit="m")] = 1e3
    min_turn: Annotated[
        float, Number("Turns about the vertical at least so far, either way", "DEG", unit="rad")
    ] = 0.0
    min_height: Annotated[
        float, Number("Lands at least so high above where it stood", "M", unit="m")
    ] = -1e3
    min_flight: Annotated[
        float, Number("Is at least so long in the air, all flights together", "S", unit="s")
    ] = 0.0
    max_power: Annotated[
        float, Number("Drives together give at most so much power", "W", unit="W")
    ] = 1e9

    def __post_init__(self) -> None:
        check_fields(self)

    def pass_(self, card: Card) -> bool:
        """Whether a motion is one of those that are looked for."""
        figures = card.figures
        return (
            self.min_distance <= figures.distance_m <= self.max_distance
            and abs(figures.turn) >= self.min_turn
            and figures.height_m >= self.min_height
            and figures.flight_s >= self.min_flight
            and figures.peak_power_w <= self.max_power
        )


def found(
    cards: Iterable[Card], words: Sequence[str] = (), filters: Filters | None = None
) -> list[Card]:
    """The motions that all words are part of, in the order of their names.

    A word is looked for in name, robot, kind and type: "back flip" finds `go2-back-flip-0001`.
    """
    filters = filters or Filters()
    wanted = [word.lower() for text in words for word in text.split()]
    kept = (card for card in cards if filters.pass_(card) and _has(card, wanted))
    return sorted(kept, key=lambda card: card.name)


def _has(card: Card, words: Sequence[str]) -> bool:
    text = f"{card.name} {card.robot} {card.kind} {card.type}".lower()
    return all(word in text for word in words)


FILTERS = tuple(field.name for field in fields(Filters))
