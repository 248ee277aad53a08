"""Tables of files (robots, jump types, designs, sweeps), read and checked strictly."""

import json
import math
import tomllib
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import ErrorDetails, PydanticCustomError

from llsrbm.errors import InputError, printable
from llsrbm.request.messages import choices
from llsrbm.text_files import read_text

LARGEST = 1e6
"""Of numbers in SI units that describe robots: larger ones ruin sums of all of them."""

_LARGEST = 1_000_000  # bytes; such files have a few thousand


def _ordered(interval: tuple[float, float]) -> tuple[float, float]:
    if interval[0] > interval[1]:
        raise PydanticCustomError("interval", "the first number (lower) exceeds the second (upper)")
    return interval


def _one_line(text: str) -> str:
    if not text.isprintable():
        raise PydanticCustomError("text", "expected one line of printable text")
    return text


Interval = Annotated[tuple[float, float], AfterValidator(_ordered)]
Vector = tuple[float, float, float]
Positive = Annotated[float, Field(gt=0)]
Length = Annotated[float, Field(ge=0)]
PositiveInterval = Annotated[tuple[Positive, Positive], AfterValidator(_ordered)]
OneLine = AfterValidator(_one_line)


class Table(BaseModel):
    """A table of a file: no unknown keys, no conversions, no changes.

    A field's `description` is the accepted value in words, for messages about unions.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


TableT = TypeVar("TableT", bound=Table)


# ---- reading


def read_table(path: Path, what: str, error: type[InputError] = InputError) -> dict[str, Any]:
    """The content of a TOML file, arrays as tuples; `what` names it, with an article, in messages.

    Raises `error`: one line that names the file and what is wrong with it.
    """
    return parse_table(read_text(path, what, _LARGEST, error), str(path), error)


def parse_table(text: str, where: str, error: type[InputError] = InputError) -> dict[str, Any]:
    """The content of a TOML text, arrays as tuples; `where` is its name in messages. Raises
    `InputError`: `error`, one line.
    """
    try:
        table: dict[str, Any] = with_tuples(tomllib.loads(text))
    except RecursionError as reason:
        raise error(f"{where}: not a TOML file: nested too deeply") from reason
    except ValueError as reason:  # TOMLDecodeError, or a number of thousands of digits
        why = str(reason).partition("; use sys.")[0]
        raise error(f"{where}: not a TOML file: {printable(why, 200)}") from reason
    return table


def with_tuples(value: Any) -> Any:
    """TOML arrays as tuples, as strict validation wants them."""
    if isinstance(value, dict):
        return {key: with_tuples(item) for key, item in value.items()}
    if isinstance(value, list):
        return tuple(with_tuples(item) for item in value)
    return value


# ---- checking


def validated(
    model: type[TableT],
    table: Any,
    where: str,
    error: type[InputError] = InputError,
    largest: float = math.inf,
) -> TableT:
    """A file's content as its model; `where` is the file's name in messages, `largest` a bound of
    its numbers either way.

    Raises `error`: one line: the file, the key, the fault and what would be accepted.
    """
    try:
        found = model.model_validate(table)
    except ValidationError as reason:
        # A misspelt key is both unknown and missing; the first says more.
        details = sorted(reason.errors(), key=lambda detail: detail["type"] != "extra_forbidden")
        keys = {_key(model, detail) for detail in details}
        more = f" (and {len(keys) - 1} more)" if len(keys) > 1 else ""
        raise error(f"{where}: {_sentence(model, details[0])}{more}") from reason
    for key, number in _numbers(found, "") if largest < math.inf else ():
        if abs(number) > largest:
            raise error(
                f"{where}: {printable(key)}: expected a number up to {largest:g} either way, got "
                f"{number:g}"
            )
    return found


def _numbers(value: Any, key: str) -> Iterator[tuple[str, float]]:
    """All numbers that a checked table has for real ones, each with its key."""
    if isinstance(value, float):
        yield key, value
    elif isinstance(value, BaseModel):
        for name, info in type(value).model_fields.items():
            yield from _numbers(getattr(value, name), f"{key}.{info.alias or name}".lstrip("."))
    elif isinstance(value, dict):
        for name, item in value.items():
            yield from _numbers(item, f"{key}.{name}".lstrip("."))
    elif isinstance(value, tuple):
        for item in value:
            yield from _numbers(item, key)


def fault(message: str) -> PydanticCustomError:
    """An error for validators whose message is a whole one: it names what would be accepted."""
    return PydanticCustomError("fault", "{message}", {"message": message})


def _sentence(model: type[Table], detail: ErrorDetails) -> str:
    key, (field, inner) = _key(model, detail), _at(model, detail)
    # TOML and JSON write values alike.
    given = printable(json.dumps(detail["input"], ensure_ascii=True, default=str))
    last = str(detail["loc"][-1]) if detail["loc"] else ""
    match detail["type"]:
        case "fault":
            return f"{key}: {detail['msg']}" if key else detail["msg"]
        case "extra_forbidden":
            return f'unknown key "{key}"; {choices(last, _names(inner))}'
        case "missing" if isinstance(detail["loc"][-1], str):
            return f'missing key "{key}"; expected: {", ".join(_names(inner))}'
        case _ if field is not None and field.description:
            return f"{key}: expected {field.description}, got {given}"
        case "missing" | "too_long" if field is not None and _length(field.annotation):
            return f"{key}: expected {_length(field.annotation)} values, got {given}"
        case "too_short":
            return f"{key}: expected at least {detail['ctx']['min_length']}, got {given}"
        case "tuple_type":
            return f"{key}: expected an array, got {given}"
        case "model_type" | "model_attributes_type" | "dict_type":
            return f"{key}: expected a table, got {given}"
        case _:
            return f"{key}: {detail['msg'][:1].lower()}{detail['msg'][1:]}, got {given}"


def _at(model: type[Table], detail: ErrorDetails) -> tuple[Any, type[Table]]:
    """The field that an error is about, None of an unknown one; and the table that holds it."""
    table, inner, field = model, model, None
    for part in detail["loc"]:
        known = {info.alias or name: info for name, info in inner.model_fields.items()}
        if part in known:
            table, field = inner, known[str(part)]
            inner = next(_models(field.annotation), inner)
    if detail["type"] in ("extra_forbidden", "missing") and isinstance(detail["loc"][-1], str):
        unknown = detail["type"] == "extra_forbidden"
        return None, inner if unknown else table
    return field, table


def _key(model: type[Table], detail: ErrorDetails) -> str:
    """The place of an error, "phase.2.feet": elements of arrays count from 1."""
    field, _ = _at(model, detail)
    parts: list[str] = []
    for part in detail["loc"]:
        if isinstance(part, int):
            parts.append(str(part + 1))
        elif "[" not in part and part not in ("str", "int", "float", "tuple"):  # of a union
            parts.append(part)
    whole = field is not None and (
        field.description or detail["type"] in ("missing", "too_long", "too_short")
    )
    while whole and parts[1:] and parts[-1].isdecimal():
        parts.pop()
    return printable(".".join(parts))


def _names(table: type[Table]) -> list[str]:
    return [info.alias or name for name, info in table.model_fields.items()]


def _models(annotation: Any) -> Iterator[type[Table]]:
    if isinstance(annotation, type) and issubclass(annotation, Table):
        yield annotation
    for part in typing.get_args(annotation):
        yield from _models(part)


def _length(annotation: Any) -> int | None:
    parts = typing.get_args(annotation)
    if typing.get_origin(annotation) is tuple and Ellipsis not in parts:
        return len(parts)
    return next(filter(None, map(_length, parts)), None)
