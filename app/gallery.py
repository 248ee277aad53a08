"""The gallery of examples: their titles, a line on each, and the moving thumbnails that ship; and
the motions of the library.

`python -m benchmarks.thumbnails` makes the thumbnails from the designs.
"""

import base64
import math
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

from llsrbm.installed import assets_directory
from llsrbm.library import shipped
from llsrbm.library.card import Figures
from llsrbm.library.stick_figure import StickFigure
from llsrbm.look.titles import title_of_robot
from llsrbm.number_text import decimal, degrees
from llsrbm.request.design import Design, examples
from llsrbm.request.jump_types import names

FOLDER = assets_directory() / "thumbnails"
_LITTLE, _LITTLE_TURN = 0.015, math.radians(2)  # m, rad: of which a list says nothing
FIRST = ("g1-pirouette", "anymal-twist", "go2-back-flip")  # that show most


def thumbnail_file(name: str) -> Path:
    """The thumbnail of the example of that name."""
    return FOLDER / f"{name}.webp"


@cache
def designs() -> dict[str, Design]:
    """The examples by their names, in the order of their cards."""
    return dict(sorted(examples().items(), key=lambda item: (*FIRST, item[0]).index(item[0])))


def cards() -> list[dict[str, str]]:
    """For the page (static/gallery.js): a card an example; its picture is an address."""
    return [
        {
            "name": name,
            "title": design.title,
            "line": first_sentence(design.note),
            "note": design.note,
            "picture": _address(thumbnail_file(name)),
        }
        for name, design in designs().items()
    ]


@cache
def motions() -> list[dict[str, str]]:
    """For the page: the motions of the library that ships, in the order of their names.

    None where it is not there.
    """
    return [
        {
            "name": card.name,
            "robot": title_of_robot(card.robot),
            "kind": title_of_kind(card.kind),
            "line": figures_in_words(card.figures),
        }
        for card in shipped().found()
    ]


def stick_figures(names: Iterable[str]) -> dict[str, dict[str, Any]]:
    """For the page: name -> what stick_figure.js draws, of those that have a stick figure."""
    figures, library = _stick_figures(), shipped()
    return {
        name: figures[name].drawn(library.card(name).figures.duration_s)
        for name in names
        if name in figures
    }


@cache
def _stick_figures() -> dict[str, StickFigure]:
    return shipped().stick_figures()


@cache
def motion_names() -> frozenset[str]:
    """Names of these motions."""
    return frozenset(motion["name"] for motion in motions())


def figures_in_words(figures: Figures) -> str:
    """Where a motion leads, as far as it leads somewhere, and how long it flies."""
    height = figures.height_m
    parts = [
        (abs(figures.turn) > _LITTLE_TURN, degrees(figures.turn, 0)),
        (figures.distance_m > _LITTLE, f"{decimal(figures.distance_m, 2)} m"),
        (abs(height) > _LITTLE, f"{'up' if height > 0 else 'down'} {decimal(abs(height), 2)} m"),
        (True, f"{decimal(figures.flight_s, 2)} s in the air"),
    ]
    return ", ".join(words for counts, words in parts if counts)


def title_of_kind(kind: str) -> str:
    """A kind of motion as in menus: the title of its jump type, or its own words."""
    known = names()
    return known[kind].title if kind in known else kind.replace("-", " ").capitalize()


def first_sentence(note: str) -> str:
    """The first sentence of a note, or all of it."""
    sentence, dot, _ = note.partition(". ")
    return f"{sentence}{dot}".strip()


def _address(path: Path) -> str:
    """The picture itself; "" for a design that has none."""
    if not path.is_file():
        return ""
    return f"data:image/webp;base64,{base64.b64encode(path.read_bytes()).decode('ascii')}"
