"""Files of a library: npz without pickle, of some motions of one robot.

    schema       "llsrbm.library/1"
    meta         JSON: robot, names of its joints, key of its numbers, package version
    NAME         (V,) float32, a motion's numbers (`llsrbm.library.stored`)
    NAME.card    JSON, its card (`llsrbm.library.card.Card`)
    NAME.stick   (1 + T, P, 2) int8, its stick figure (`llsrbm.library.stick_figure`); older files
                 have none

A motion's numbers are read when it is opened, the others of the file are not.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import BaseModel, Field, ValidationError

from llsrbm.errors import FileFormatError, InputError, printable
from llsrbm.files.native import check_schema
from llsrbm.files.npz import Arrays, open_archive, text, write_archive
from llsrbm.installed import package_version
from llsrbm.library.card import Card
from llsrbm.library.stick_figure import StickFigure
from llsrbm.library.stored import Stored
from llsrbm.robots.numbers_key import numbers_key
from llsrbm.robots.robot import Robot

SCHEMA = "llsrbm.library/1"
MOST = 1000  # motions of a file: of more, reading its names takes long
_CARD, _STICK = ".card", ".stick"
_EXPECTED = "expected a file of a library, as `llsrbm library build` writes"


class FileMeta(BaseModel):
    """The JSON at `meta`: of which robot the motions are, by which numbers of it."""

    robot: Annotated[str, Field(min_length=1, max_length=200)]
    joint_names: Annotated[list[str], Field(max_length=1000)]
    numbers: Annotated[str, Field(max_length=100)]
    package_version: Annotated[str, Field(max_length=100)]

    @classmethod
    def of(cls, robot: Robot) -> Self:
        """A robot's as it is now."""
        return cls(
            robot=robot.name,
            joint_names=list(robot.joint_names),
            numbers=numbers_key(robot),
            package_version=package_version(),
        )


@dataclass(frozen=True, eq=False)
class StoredMotion:
    """A card, the numbers of its motion, and its stick figure; None: it has none yet."""

    card: Card
    numbers: Stored
    figure: StickFigure | None = None


def write(path: Path, meta: FileMeta, motions: Iterable[StoredMotion]) -> None:
    """Write a file, atomically. Raises `InputError`: it cannot be written."""
    arrays: dict[str, Any] = {"schema": np.array(SCHEMA), "meta": np.array(meta.model_dump_json())}
    for motion in motions:
        arrays[motion.card.name] = motion.numbers
        arrays[motion.card.name + _CARD] = np.array(motion.card.model_dump_json())
        if motion.figure is not None:
            arrays[motion.card.name + _STICK] = motion.figure.array
    write_archive(path, arrays)


def read_cards(path: Path) -> tuple[FileMeta, list[Card]]:
    """The meta and the cards of a file. Raises `FileFormatError`: of no library, or damaged."""
    with open_archive(path, _EXPECTED) as archive:
        names = sorted(key for key in archive.keys if key.endswith(_CARD))
        arrays = archive.arrays(["schema", "meta", *names])
    meta = _meta(arrays, path)
    return meta, [_card(arrays, name, meta, path) for name in names]


def read_numbers(path: Path, name: str) -> Stored:
    """The numbers of one motion. Raises `FileFormatError`: it is not there, or damaged."""
    with open_archive(path, _EXPECTED) as archive:
        arrays = archive.arrays([name])
    found = arrays.get(name)
    if found is None or found.ndim != 1 or found.dtype != np.float32:
        raise FileFormatError(f'{path}: key "{name}": expected a row of numbers in float32')
    if not np.isfinite(found).all():
        raise FileFormatError(f'{path}: key "{name}": expected finite numbers')
    return found


def read_stick_figures(path: Path, names: Iterable[str] | None = None) -> dict[str, StickFigure]:
    """The stick figures that the motions `names`, or all of them, have in a file.

    Raises `FileFormatError`: one is damaged.
    """
    with open_archive(path, _EXPECTED) as archive:
        wanted = archive.keys if names is None else {name + _STICK for name in names}
        arrays = archive.arrays(key for key in wanted if key.endswith(_STICK))
    found = {}
    for key, array in arrays.items():
        try:
            found[key.removesuffix(_STICK)] = StickFigure.of_array(array)
        except ValueError as error:
            raise FileFormatError(f'{path}: key "{key}": {error}') from error
    return found


def _meta(arrays: Arrays, path: Path) -> FileMeta:
    check_schema(arrays, path, SCHEMA)
    try:
        return FileMeta.model_validate_json(text(arrays, "meta", path))
    except ValidationError as error:
        raise _wrong(path, "meta", error) from error


def _card(arrays: Arrays, key: str, meta: FileMeta, path: Path) -> Card:
    try:
        card = Card.model_validate_json(text(arrays, key, path))
    except ValidationError as error:
        raise _wrong(path, key, error) from error
    except InputError as error:  # the request's own checks
        raise FileFormatError(f'{path}: key "{key}": {printable(str(error), 300)}') from error
    if card.name + _CARD != key or card.robot != meta.robot:
        raise FileFormatError(f'{path}: key "{key}": it is the card of {card.name}, {card.robot}')
    return card


def _wrong(path: Path, key: str, error: ValidationError) -> FileFormatError:
    first = error.errors()[0]
    place = printable(".".join(str(part) for part in first["loc"])) or "JSON"
    return FileFormatError(f'{path}: key "{key}": {place}: {printable(first["msg"], 200)}')


def as_text(value: Mapping[str, Any]) -> str:
    """Plain data as the text of a JSON file."""
    return json.dumps(value, indent=1, allow_nan=False) + "\n"
