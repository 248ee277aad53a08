"""Jump types in a line: the order in which feet stand, such as "all - right - none - right - all".

Each word says who stands in a phase: what a type's file says for `feet`, legs joined by "+". How
long phases may last follows from where they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from llsrbm.errors import InputError, printable
from llsrbm.request.schedule import LONGEST_NAME

BETWEEN, BESIDE = " - ", "+"
MOST = 12  # phases; those of five jumps in a row are eleven
# Shortest and longest, s: with some feet, as of the presets; between jumps, as a rebound or a step;
# of flights that begin or end on some feet.
_SOME, _AGAIN, _SHORT_FLIGHT = (0.06, 0.6), (0.2, 1.4), (0.12, 0.6)
_SHARE = {"some": 0.6, "all": 1.5}  # of a whole phase's intervals


def is_order(name: str) -> bool:
    """Whether a jump type's name is the order of its feet."""
    return BETWEEN in name and not name.endswith(".toml")


def order_of(feet: Sequence[tuple[str, ...]], legs: tuple[str, ...]) -> str:
    """The order of phases with these feet, names of `legs`."""
    words = {(): "none", legs: "all"}
    return BETWEEN.join(words.get(each) or BESIDE.join(each) for each in feet)


def table_of(order: str) -> dict[str, Any]:
    """The jump type of an order as its file would have it.

    Raises `InputError`: more phases than may be, or a word that is empty.
    """
    words = [word.strip() for word in order.split(BETWEEN)]
    if len(words) > MOST or not all(part.strip() for w in words for part in w.split(BESIDE)):
        raise InputError(
            f'jump type "{printable(order)}": expected at most {MOST} phases with feet in each, '
            'such as "all - right - none - right - all"'
        )
    flight = words.index("none") if "none" in words else len(words)
    return {
        "title": "Own order of feet",
        "summary": printable(order, 200),
        "phase": tuple(_phase(words, k, before=k < flight) for k in range(len(words))),
    }


def _phase(words: list[str], k: int, *, before: bool) -> dict[str, Any]:
    word, last = words[k], len(words) - 1
    if word == "none":
        whole = {words[max(k - 1, 0)], words[min(k + 1, last)]} == {"all"}
        return {"name": "flight", "feet": word, "time": "flight" if whole else _SHORT_FLIGHT}
    if k in (0, last):
        return {
            "name": "landing" if k else "take-off",
            "feet": word,
            "time": "landing" if k else "takeoff",
        }
    if word == "all":
        return {"name": "rebound", "feet": word, "time": _AGAIN, "share": _SHARE["all"]}
    names = tuple(part.strip() for part in word.split(BESIDE))
    return {
        "name": f"{'push' if before else 'landing'} on {', '.join(names)}"[:LONGEST_NAME],
        "feet": names if len(names) > 1 else word,
        "time": _SOME,
        "share": _SHARE["some"],
    }
