"""Designs as files: a jump, what it changes about the planner, and the scenario to follow it in.

A file is JSON; angles in rad, lengths in m, limits in their SI units, whatever a page shows:

    {
      "schema": "llsrbm.design/1",
      "title": "On ice",
      "jump": {"robot": "anymal", "model": "llsrbm-plus", "twist": 1.0, "forward": 0.0, ...},
      "weights": {"time": 10.0},
      "limits": {"friction": 0.2},
      "scenario": {"board": 0.025, "seed": 7}
    }

`schema`, robot and model must be there; what is left out has its default.
"""

import json
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator

from llsrbm.errors import FileFormatError, InputError, printable
from llsrbm.installed import assets_directory
from llsrbm.request.jump import AMOUNTS, Jump
from llsrbm.request.messages import check_kind, choices, field_specs, look_up
from llsrbm.request.scenario import Scenario
from llsrbm.request.tables import OneLine, Table, fault, validated
from llsrbm.request.tuning import Tuning
from llsrbm.text_files import decoded, parse_json, read_text

SCHEMA = "llsrbm.design/1"
SUFFIX = ".jump.json"
LARGEST = 64_000  # bytes; a design with every weight and limit changed takes a tenth of it

_WHAT = f"a design ({SCHEMA})"
_LONGEST_TITLE, _LONGEST_NOTE = 80, 400  # characters: a line of a list, a few lines of a page
_ALWAYS = ("robot", "model", "twist", "forward", "lateral", "height")  # stated even if they are 0
_FARTHEST = 100.0  # rad, m or m/s; far beyond any robot, whose range is checked when it plans
_LARGEST_SEED = 2**53 - 1  # the largest whole number that every reader of JSON keeps exact


@dataclass(frozen=True)
class Design:
    """Everything that was decided about one jump."""

    jump: Jump  # the request
    tuning: Tuning = field(default_factory=Tuning)  # weights and limits in place of the robot's own
    scenario: Scenario = field(default_factory=Scenario)  # to simulate it in
    title: str = ""  # to choose it by, in one line of at most 80 characters
    note: str = ""  # what to look at, at most 400 characters


def dump_design(design: Design) -> str:
    """A design as the text of a file: robot, model and task, and what differs from the defaults.
    Raises `InputError`: a title, a name or a number that no file may hold.
    """
    check_kind("design", design, Design, "a Design")
    differing = {
        "title": design.title,
        "note": design.note,
        "jump": _stated(design.jump),
        "weights": dict(design.tuning.weights),
        "limits": dict(design.tuning.limits),
        "scenario": design.scenario.stated(),
    }
    table = {"schema": SCHEMA} | {name: value for name, value in differing.items() if value}
    _checked(table, "this design")
    return json.dumps(table, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _stated(jump: Jump) -> dict[str, Any]:
    """Robot, model and where to land, and of the rest what differs from the defaults."""
    table, plain = jump.as_dict(), Jump().as_dict()
    return {n: value for n, value in table.items() if n in _ALWAYS or value != plain.get(n)}


def load_design(source: bytes | str | Path, *, name: str = "design") -> Design:
    """The design in a file, or in a file's content (bytes), which messages call `name`.

    Raises `FileFormatError`: it cannot be read, or is no design; one line that says what is
    accepted. Whether the robot can do it is checked when it is planned.
    """
    if isinstance(source, bytes):
        where = printable(name)
        if len(source) > LARGEST:
            raise FileFormatError(f"{where}: too large for {_WHAT}; at most {LARGEST} bytes")
        return _parse(decoded(source, where, _WHAT), where)
    return _parse(read_text(source, _WHAT, LARGEST, piped=True), str(source))


def file_name(design: Design) -> str:
    """Under which to save a design: its title, or else its robot, in plain letters."""
    words = re.findall(r"[a-z0-9]+", (design.title or Path(design.jump.robot).stem).lower())
    return ("-".join(words) or "design") + SUFFIX


def examples() -> dict[str, Design]:
    """The designs that come with the project, name -> design, in the order to show them in."""
    files = sorted((assets_directory() / "designs").glob(f"*{SUFFIX}"))
    # A number before the name keeps the order.
    return {
        re.sub(r"^\d+-", "", path.name.removesuffix(SUFFIX)): load_design(path) for path in files
    }


def find_design(name_or_path: str) -> Design:
    """The example of that name, or the design in the file at that path.

    What ends in ".json" or contains a path separator is a path. Raises `InputError`: no such
    example; `FileFormatError`: the file is no design.
    """
    if name_or_path.endswith(".json") or os.sep in name_or_path:
        return load_design(name_or_path)
    return look_up("design", name_or_path, examples(), "or the path of a design's file (.json)")


# ---- what a file may hold


_Name = Annotated[str, Field(min_length=1, max_length=1000), OneLine]  # may be a path
_Value = Annotated[float, Field(ge=-1e9, le=1e9)]


def _jump(table: Any) -> Jump:
    jump: Jump = _made(Jump, table, needed=("robot", "model"))
    for name in AMOUNTS:
        if abs(getattr(jump, name)) > _FARTHEST:
            raise fault(f"{name}: expected -{_FARTHEST:g} to {_FARTHEST:g}, got {table[name]:g}")
    return jump


def _scenario(table: Any) -> Scenario:
    scenario: Scenario = _made(Scenario, table)
    if (scenario.seed or 0) > _LARGEST_SEED:
        raise fault(f"seed: expected at most {_LARGEST_SEED} in a file")
    return scenario


def _made(kind: Any, table: Any, needed: Sequence[str] = ()) -> Any:
    known = list(field_specs(kind))
    if not isinstance(table, Mapping):
        raise fault(f"expected an object, got {_short(table)}")
    for name in table:
        if name not in known:
            raise fault(f"unknown key {_short(name)}; {choices(str(name), known)}")
    for name in needed:
        if name not in table:
            raise fault(f'missing key "{name}"; expected: {", ".join(known)}')
    try:
        return kind(**table)
    except InputError as error:
        raise fault(str(error)) from error


class _File(Table):
    schema_: Annotated[Literal["llsrbm.design/1"], Field(alias="schema")]
    title: Annotated[str, Field(max_length=_LONGEST_TITLE), OneLine] = ""
    note: Annotated[str, Field(max_length=_LONGEST_NOTE), OneLine] = ""
    jump: Annotated[Jump, PlainValidator(_jump)]
    weights: dict[_Name, _Value] = Field(default_factory=dict)
    limits: dict[_Name, _Value] = Field(default_factory=dict)
    scenario: Annotated[Scenario, PlainValidator(_scenario)] = Scenario()


def _parse(text: str, where: str) -> Design:
    file = _checked(parse_json(text, where), where)
    return Design(
        jump=file.jump,
        tuning=Tuning(weights=file.weights, limits=file.limits),
        scenario=file.scenario,
        title=file.title,
        note=file.note,
    )


def _checked(table: Any, where: str) -> _File:
    if not isinstance(table, Mapping) or "schema" not in table:
        raise FileFormatError(
            f'{where}: not a design; expected an object with "schema": "{SCHEMA}"'
        )
    if table["schema"] != SCHEMA:
        raise FileFormatError(
            f'{where}: schema: expected "{SCHEMA}", got {_short(table["schema"])}'
        )
    return validated(_File, dict(table), where, FileFormatError)


def _short(value: Any) -> str:
    return printable(json.dumps(value, ensure_ascii=True, default=str))
