"""Reading a sweep's spec, and one line about what is wrong with it."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from llsrbm.errors import InputError, printable
from llsrbm.installed import assets_directory
from llsrbm.request.messages import choices
from llsrbm.request.tables import Table, parse_table, read_table
from llsrbm.sweep.axes import AxisTable, DriveAxes, JumpAxes
from llsrbm.sweep.spec import Spec

SUFFIX = ".toml"


def find_spec(name_or_path: str) -> Spec:
    """The spec of that name among those that come with the project, or in the file at that path.

    What ends in ".toml" or contains a path separator is a path.

    Raises:
        InputError: no such name, or the file is no spec; one line that says what is accepted.
    """
    if name_or_path.endswith(SUFFIX) or os.sep in name_or_path:
        return read_spec(Path(name_or_path))
    known = {path.stem: path for path in sorted((assets_directory() / "sweeps").glob("*.toml"))}
    if name_or_path not in known:
        raise InputError(
            f'no sweep "{name_or_path}"; {choices(name_or_path, known)}, '
            "or the path of a spec's file (.toml)"
        )
    return read_spec(known[name_or_path])


def read_spec(path: Path) -> Spec:
    """Read and check a spec; robots and limits are checked by `points`.

    Raises:
        InputError: one line naming the file, the key, what was given and what is accepted.
    """
    return _checked(read_table(path, "a sweep's spec"), str(path))


def parse_spec(text: str, where: str) -> Spec:
    """A spec from the text of its file; `where` is what messages call it.

    Raises:
        InputError: as `read_spec`.
    """
    return _checked(parse_table(text, where), where)


def _checked(table: dict[str, Any], where: str) -> Spec:
    try:
        return Spec.model_validate(table)
    except ValidationError as error:
        # A misspelt key is both unknown and missing; the first says more.
        details = sorted(error.errors(), key=lambda detail: detail["type"] != "extra_forbidden")
        raise InputError(f"{where}: {_sentence(details[0])}") from error


def _sentence(detail: ErrorDetails) -> str:
    """One pydantic complaint as: key, what was wrong, what would be accepted."""
    # A list is the table's "values", whether its file says so or not.
    hidden = {"values"} if detail["type"] != "extra_forbidden" else set()
    location = [
        f"value {part + 1}" if isinstance(part, int) else part
        for part in detail["loc"]
        if not _is_alternative(part) and part not in hidden
    ]
    key, last = printable(".".join(location)), location[-1] if location else ""
    given = printable(repr(detail["input"]))
    match detail["type"]:
        case "extra_forbidden":
            return f'unknown key "{key}"; {choices(last, _keys(location[:-1]))}'
        case "missing":
            return f'missing key "{key}"; expected: {", ".join(_keys(location[:-1]))}'
        case "wrong":
            return f"{key}: {detail['msg']}" if location else detail["msg"]
        case "model_type" | "dict_type" | "model_attributes_type" if location[:1] == ["axes"]:
            return f"{key}: expected a number, a list or a table, got {given}"
        case "model_type" | "dict_type" | "model_attributes_type" | "literal_error" if (
            last != "sampling"
        ):
            return f"{key}: expected a table, got {given}"
        case "too_short":
            return f"{key}: is empty; expected at least one value"
        case "tuple_type":
            return f"{key}: expected a list, got {given}"
        case _:
            message = detail["msg"][:1].lower() + detail["msg"][1:]
            return f"{key}: {message}, got {given}"


def _keys(location: list[str]) -> list[str]:
    """What may stand in the table at a location."""
    tables: dict[str, type[Table]] = {"axes": JumpAxes, "drives": DriveAxes}
    table: type[Table] = Spec
    if len(location) == 1:
        table = tables.get(location[0], AxisTable)
    elif location:
        table = AxisTable
    return [info.alias or name for name, info in table.model_fields.items()]


def _is_alternative(part: str | int) -> bool:
    """Whether a part of pydantic's location names one of several kinds that a value may be of."""
    text = str(part)
    return "[" in text or text in ("AxisTable", "tuple", "[key]")
