"""What TOML files of robots, jump types and sweeps have in common: how they are read, strictly."""

from __future__ import annotations

import stat
import tomllib
from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field
from pydantic_core import PydanticCustomError

from llsrbm.errors import InputError, printable

_LARGEST = 1_000_000  # bytes; such files have a few thousand


def _ordered(interval: tuple[float, float]) -> tuple[float, float]:
    if interval[0] > interval[1]:
        raise PydanticCustomError("interval", "the first number (lower) exceeds the second (upper)")
    return interval


Interval = Annotated[tuple[float, float], AfterValidator(_ordered)]
Vector = tuple[float, float, float]
Positive = Annotated[float, Field(gt=0)]
Length = Annotated[float, Field(ge=0)]
PositiveInterval = Annotated[tuple[Positive, Positive], AfterValidator(_ordered)]


class Table(BaseModel):
    """A table of a file: no unknown keys, no conversions, no changes."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


def read_table(path: Path, what: str, error: type[InputError] = InputError) -> dict[str, Any]:
    """What a TOML file holds, arrays as tuples.

    Args:
        path: of the file.
        what: it is said to be, with its article, where it is too large.
        error: what is raised.

    Raises:
        InputError: `error`, one line that names the file and what is wrong with it.
    """
    try:
        # The path may come from a stranger's plan: no device is read, no pipe waited for.
        kind = path.stat().st_mode
        if not stat.S_ISREG(kind) and not stat.S_ISDIR(kind):
            raise error(f"{path}: cannot be read (not a regular file)")
        with path.open("rb") as file:
            content = file.read(_LARGEST + 1)
        if len(content) > _LARGEST:
            raise error(f"{path}: too large for {what}; at most {_LARGEST} bytes")
        text = content.decode()
    except OSError as reason:
        raise error(f"{path}: cannot be read ({reason.strerror})") from reason
    except UnicodeDecodeError as reason:
        raise error(f"{path}: not a text file in UTF-8") from reason
    return parse_table(text, str(path), error)


def parse_table(text: str, where: str, error: type[InputError] = InputError) -> dict[str, Any]:
    """What the text of a TOML file holds, arrays as tuples; `where` is what messages call it.

    Raises:
        InputError: `error`, one line.
    """
    try:
        table: dict[str, Any] = with_tuples(tomllib.loads(text))
    except RecursionError as reason:
        raise error(f"{where}: not a TOML file: nested too deeply") from reason
    except ValueError as reason:  # TOMLDecodeError, or a number of thousands of digits
        told = str(reason).partition("; use sys.")[0]
        raise error(f"{where}: not a TOML file: {printable(told, 200)}") from reason
    return table


def with_tuples(value: Any) -> Any:
    """TOML arrays as tuples, which strict validation asks for."""
    if isinstance(value, dict):
        return {key: with_tuples(item) for key, item in value.items()}
    if isinstance(value, list):
        return tuple(with_tuples(item) for item in value)
    return value
