"""Motions by words and by figures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from llsrbm.errors import InputError
from llsrbm.library.card import KINDS, Card
from llsrbm.request.jump_types import names
from llsrbm.request.messages import Number, check_kind, look_up
from llsrbm.robots.schema import robot_files

_NAMES = "robot", "kind"  # the filters that are no numbers


@dataclass(frozen=True)
class Filters:
    """Least and largest figures of motions that are looked for; None: any.

    Attributes:
        robot, kind: names.
        min_distance, max_distance: m that it leads horizontally.
        min_turn: rad about the vertical, either way; min_height: m that it lands above its start.
        min_flight: s in the air, all flights together; max_power: W that the drives give at most.

    Raises:
        InputError: a number that is not finite, a least figure beyond the largest.
    """

    robot: str | None = None
    kind: str | None = None
    min_distance: float | None = None
    max_distance: float | None = None
    min_turn: float | None = None
    min_height: float | None = None
    min_flight: float | None = None
    max_power: float | None = None

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if value is not None and name not in _NAMES:
                Number("").checked(name, value)
        low, high = self.min_distance, self.max_distance
        if low is not None and high is not None and low > high:
            raise InputError(
                f"min_distance {low:g} is beyond max_distance {high:g}; expected the least first"
            )

    def fit(self, card: Card) -> bool:
        """Whether a motion is one of those that are looked for."""
        figures = card.figures
        least = (
            (figures.distance_m, self.min_distance),
            (abs(figures.turn), self.min_turn),
            (figures.height_m, self.min_height),
            (figures.flight_s, self.min_flight),
        )
        most = (figures.distance_m, self.max_distance), (figures.peak_power_w, self.max_power)
        same = (card.robot, self.robot), (card.kind, self.kind)
        return (
            all(wanted in (None, own) for own, wanted in same)
            and all(low is None or own >= low for own, low in least)
            and all(high is None or own <= high for own, high in most)
        )


def found(
    cards: Iterable[Card], words: Sequence[str] = (), filters: Filters | None = None
) -> list[Card]:
    """The motions that all words are part of, in the order of their names.

    A word is looked for in name, robot, kind and type: "back flip" finds `go2-back-flip-0001`.

    Raises:
        InputError: words that are none, filters with a robot or a kind that there is not.
    """
    check_kind("words", words, Sequence, "a list of words")
    check_kind("filters", filters, Filters | None, "Filters")
    words = [words] if isinstance(words, str) else words
    for word in words:
        check_kind("words", word, str, "words")
    filters, cards = filters or Filters(), list(cards)
    for what, given, own in (
        ("robot", filters.robot, [*robot_files(), *(card.robot for card in cards)]),
        ("kind", filters.kind, [*KINDS, *names(), *(card.kind for card in cards)]),
    ):
        if given is not None:
            look_up(what, given, dict.fromkeys(own))
    wanted = [word.lower() for text in words for word in text.split()]
    kept = (card for card in cards if filters.fit(card) and _has(card, wanted))
    return sorted(kept, key=lambda card: card.name)


def _has(card: Card, words: Sequence[str]) -> bool:
    text = f"{card.name} {card.robot} {card.kind} {card.type}".lower()
    return all(word in text for word in words)
