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

`schema`, the robot and the model must be there; a key that is left out has its default, a key that
is not known is refused. The names are those of `Jump`, `Tuning` and `Scenario`. Older files call
the scenario "conditions". Of a jump the type, whole turns, speeds and hops are written only where
they differ from those of a jump from rest to rest with all feet together.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, Field, PlainValidator, ValidationError
from pydantic_core import ErrorDetails, PydanticCustomError

from llsrbm.errors import FileFormatError, InputError, printable
from llsrbm.request.jump import MOST_HOPS, Jump
from llsrbm.request.scenario import Scenario, with_scenario
from llsrbm.request.tuning import Tuning
from llsrbm.robots.schema import choices
from llsrbm.robots.tables import Table

SCHEMA = "llsrbm.design/1"
SUFFIX = ".jump.json"
LARGEST = 64_000  # bytes; a design with every weight and limit changed takes a tenth of it

_LONGEST_TITLE, _LONGEST_NOTE = 80, 400  # characters: a line of a list, a few lines of a page
_ALWAYS = ("robot", "model", "twist", "forward", "lateral", "height")  # stated even if they are 0
_FARTHEST = 100.0  # rad, m or m/s; far beyond any robot, whose range is checked when it plans
_LARGEST_SEED = 2**53 - 1  # the largest whole number that every reader of JSON keeps exact


@dataclass(frozen=True)
class Design:
    """Everything that was decided about one jump.

    Attributes:
        jump: the request.
        tuning: weights and limits in place of the robot's own.
        scenario: to simulate it in.
        title: to choose it by, in one line of at most 80 characters.
        note: what to look at, at most 400 characters.
    """

    jump: Jump
    tuning: Tuning = field(default_factory=Tuning)
    scenario: Scenario = field(default_factory=Scenario)
    title: str = ""
    note: str = ""


def dump_design(design: Design) -> str:
    """A design as the text of a file: robot, model and task, and what differs from the defaults.

    Raises:
        InputError: a title, a name or a number that no file may hold.
    """
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
    return {n: value for n, value in table.items() if n in _ALWAYS or value != plain[n]}


def load_design(source: bytes | str | Path, *, name: str = "design") -> Design:
    """The design in a file, or in a file's content.

    Args:
        source: the content as bytes, or a path.
        name: what messages call a content that came without a path.

    Raises:
        FileFormatError: it cannot be read, or is no design; one line that says what is accepted.
            Whether the robot can do it is said when it is planned.
    """
    if isinstance(source, bytes):
        return _parse(source, printable(name))
    try:
        with Path(source).open("rb") as file:
            # What is larger is refused without reading it all.
            content = file.read(LARGEST + 1)
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else str(error)
        raise FileFormatError(f"{source}: cannot be read ({why})") from error
    return _parse(content, str(source))


def file_name(design: Design) -> str:
    """Under which to save a design: its title, or else its robot, in plain letters."""
    words = re.findall(r"[a-z0-9]+", (design.title or Path(design.jump.robot).stem).lower())
    return ("-".join(words) or "design") + SUFFIX


# ---- what a file may hold


def _one_line(text: str) -> str:
    if not text.isprintable():
        raise PydanticCustomError("text", "expected one line of printable text")
    return text


_OneLine = AfterValidator(_one_line)
_Name = Annotated[
    str, Field(min_length=1, max_length=1000), _OneLine
]  # robot and type may be paths
_Amount = Annotated[float, Field(ge=-_FARTHEST, le=_FARTHEST)]
_Value = Annotated[float, Field(ge=-1e9, le=1e9)]


class _JumpTable(Table):
    robot: _Name
    model: _Name
    twist: _Amount = 0.0
    forward: _Amount = 0.0
    lateral: _Amount = 0.0
    height: _Amount = 0.0
    type: _Name = Jump.type
    roll: _Amount = 0.0
    pitch: _Amount = 0.0
    speed: _Amount = 0.0
    end_speed: _Amount = 0.0
    hops: Annotated[int, Field(ge=1, le=MOST_HOPS)] = 1


def _scenario(table: Any) -> Scenario:
    """A scenario from its table; `Scenario` says itself what may be in it."""
    if not isinstance(table, Mapping):
        raise PydanticCustomError("dict_type", "expected an object")
    try:
        scenario = Scenario().but(**table)
    except InputError as error:
        raise PydanticCustomError("scenario", "{why}", {"why": str(error)}) from error
    if (scenario.seed or 0) > _LARGEST_SEED:
        raise PydanticCustomError("scenario", f"seed: expected at most {_LARGEST_SEED} in a file")
    return scenario


class _File(Table):
    schema_: Annotated[Literal["llsrbm.design/1"], Field(alias="schema")]
    title: Annotated[str, Field(max_length=_LONGEST_TITLE), _OneLine] = ""
    note: Annotated[str, Field(max_length=_LONGEST_NOTE), _OneLine] = ""
    jump: _JumpTable
    weights: dict[_Name, _Value] = Field(default_factory=dict)
    limits: dict[_Name, _Value] = Field(default_factory=dict)
    scenario: Annotated[Scenario, PlainValidator(_scenario)] = Scenario()


def _parse(content: bytes, where: str) -> Design:
    if len(content) > LARGEST:
        raise FileFormatError(
            f"{where}: too large for a design; expected at most {LARGEST // 1000} kB"
        )
    try:
        table = json.loads(
            content.decode(),
            object_pairs_hook=_without_duplicates,
            parse_constant=_no_constant,
        )
    except InputError as error:
        raise FileFormatError(f"{where}: {error}") from error
    except UnicodeDecodeError as error:
        raise FileFormatError(
            f"{where}: not a text file in UTF-8; expected a design ({SCHEMA})"
        ) from error
    except RecursionError as error:
        raise FileFormatError(f"{where}: nested too deeply for a design ({SCHEMA})") from error
    except ValueError as error:  # JSONDecodeError, or a number of thousands of digits
        told = str(error).partition("; use sys.")[0]
        raise FileFormatError(f"{where}: not a JSON file: {told}") from error
    file = _checked(table, where)
    try:
        jump = Jump(**file.jump.model_dump())
    except InputError as error:  # a turn that is no whole one
        raise FileFormatError(f"{where}: {error}") from error
    return Design(
        jump=jump,
        tuning=Tuning(weights=file.weights, limits=file.limits),
        scenario=file.scenario,
        title=file.title,
        note=file.note,
    )


def _without_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table: dict[str, Any] = {}
    for name, value in pairs:
        if name in table:
            raise InputError(f"{_short(name)} appears twice; expected every key once")
        table[name] = value
    return table


def _no_constant(word: str) -> float:
    raise InputError(f"expected finite numbers, got {word}")


def _checked(table: Any, where: str) -> _File:
    if not isinstance(table, Mapping) or "schema" not in table:
        raise FileFormatError(
            f'{where}: not a design; expected an object with "schema": "{SCHEMA}"'
        )
    if table["schema"] != SCHEMA:
        raise FileFormatError(
            f'{where}: schema: expected "{SCHEMA}", got {_short(table["schema"])}'
        )
    try:
        return _File.model_validate(with_scenario(table))
    except ValidationError as error:
        # A misspelt key is both unknown and missing; the first says more.
        details = sorted(error.errors(), key=lambda detail: detail["type"] != "extra_forbidden")
        more = f" (and {len(details) - 1} more)" if len(details) > 1 else ""
        raise FileFormatError(f"{where}: {_sentence(details[0])}{more}") from error


def _sentence(detail: ErrorDetails) -> str:
    """One pydantic complaint as: key, what was wrong, what would be accepted."""
    location = [str(part) for part in detail["loc"] if part != "[key]"]
    key = printable(".".join(location))
    match detail["type"]:
        case "extra_forbidden":
            known = _keys(location[:-1])
            return f"unknown key {_short(location[-1])}; {choices(location[-1], known)}"
        case "missing":
            return f'missing key "{key}"; expected: {", ".join(_keys(location[:-1]))}'
        case "scenario":
            return f"{key}: {detail['msg']}"
        case "model_type" | "dict_type":
            return f"{key}: expected an object, got {_short(detail['input'])}"
        case _:
            message = detail["msg"][:1].lower() + detail["msg"][1:]
            return f"{key}: {message}, got {_short(detail['input'])}"


def _keys(location: list[str]) -> list[str]:
    """What may stand in the table at a location."""
    table: type[BaseModel] = _JumpTable if location else _File
    return [info.alias or name for name, info in table.model_fields.items()]


def _short(value: Any) -> str:
    return printable(json.dumps(value, ensure_ascii=True, default=str))
