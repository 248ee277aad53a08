"""The library of motions: certified plans that are found by words and opened at once.

A library is a folder of npz files (`llsrbm.library.file`), each of one robot's motions; one ships
in `assets/library`. A motion is the whole body's, in float32, with a card (`llsrbm.library.card`)
that says what it is and what the checks and simulations found. It is opened as a `Plan` without a
solver.
"""

from llsrbm.library.card import Card
from llsrbm.library.library import Library, shipped
from llsrbm.library.search import Filters

__all__ = ["Card", "Filters", "Library", "shipped"]
