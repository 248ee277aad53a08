"""The gallery of examples: their titles, a line on each, and the moving thumbnails that ship.

`python -m benchmarks.thumbnails` makes the thumbnails from the designs.
"""

import base64
from functools import cache
from pathlib import Path

from llsrbm.installed import assets_directory
from llsrbm.request.design import Design, examples

FOLDER = assets_directory() / "thumbnails"
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


def first_sentence(note: str) -> str:
    """The first sentence of a note, or all of it."""
    sentence, dot, _ = note.partition(". ")
    return f"{sentence}{dot}".strip()


def _address(path: Path) -> str:
    """The picture itself; "" for a design that has none."""
    if not path.is_file():
        return ""
    return f"data:image/webp;base64,{base64.b64encode(path.read_bytes()).decode('ascii')}"
