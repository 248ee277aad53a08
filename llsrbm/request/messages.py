"""Values that are given, their checks, and the words of messages about them.

A dataclass states each field's meaning, unit and range once, with its type:
`board: Annotated[float, Number(...)]`. Messages, options of the command line and documentation take
them from there.
"""

import difflib
import math
import reprlib
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, fields
from functools import cache
from numbers import Integral, Real
from types import UnionType
from typing import Any, TypeVar, get_type_hints

from llsrbm.errors import InputError, printable

T = TypeVar("T")

_SHOWN = 20  # names in a message, of more the nearest
_LONGEST_NAME = 100  # characters; messages and pages show names in a line


# ---- names


def choices(given: str, valid: Iterable[str]) -> str:
    """The part of a message that names the accepted values, the closest match first."""
    names = list(valid)
    close = difflib.get_close_matches(given, names, n=1)
    listed = ", ".join(printable(name, _LONGEST_NAME) for name in names[:_SHOWN])
    if len(names) > _SHOWN:
        nearest = difflib.get_close_matches(given, names, n=_SHOWN, cutoff=0.0)
        shown = (printable(name, _LONGEST_NAME) for name in nearest)
        listed = ", ".join(shown) + f" and {len(names) - _SHOWN} more"
    meant = f'did you mean "{printable(close[0], _LONGEST_NAME)}"? ' if close else ""
    return f"{meant}valid: {listed}"


def look_up(kind: str, name: str, entries: Mapping[str, T], otherwise: str = "") -> T:
    """The entry of that name; `kind` ("model") and `otherwise` ("or a path") are for the message.

    Raises `InputError`: there is none.
    """
    if not isinstance(name, str):
        raise _refused(kind, "a name as text", name)
    if name not in entries:
        more = f", {otherwise}" if otherwise else ""
        raise InputError(f'no {kind} "{printable(name)}"; {choices(name, entries)}{more}')
    return entries[name]


# ---- arguments of functions


def check_kind(name: str, value: Any, kind: type | UnionType, expected: str) -> None:
    """Raise `InputError` unless an argument is an instance of `kind`, which `expected` names."""
    if not isinstance(value, kind):
        raise InputError(f"{name}: expected {expected}, got {type(value).__name__}")


def check_functions(**functions: Any) -> None:
    """Raise `InputError` unless each argument of a name is a function or None."""
    for name, function in functions.items():
        if function is not None and not callable(function):
            raise _refused(name, "a function or None", function)


# ---- fields of dataclasses


@dataclass(frozen=True)
class FieldSpec(ABC):
    """Meaning and check of a field."""

    help: str  # one sentence without its full stop
    symbol: str = ""  # stands for the value where a usage is shown, "M"; "": its type does

    @property
    def accepted(self) -> str:
        """The range with its unit, "0 to 1 m"; "" where the type says it all."""
        return ""

    @abstractmethod
    def checked(self, name: str, value: Any) -> Any:
        """The value as the field `name` holds it, a scalar of NumPy as Python's own.

        Raises `InputError`: of another type, or out of range.
        """


@dataclass(frozen=True)
class Number(FieldSpec):
    """A real number in a range."""

    low: float = -math.inf  # the range, both included
    high: float = math.inf  # the range, both included
    unit: str = ""  # of the value and of the range

    @property
    def accepted(self) -> str:
        if self.low == -math.inf and self.high == math.inf:
            return ""
        return f"{self.low:g} to {self.high:g} {self.unit}".rstrip()

    def checked(self, name: str, value: Any) -> float:
        number = math.nan
        if not isinstance(value, bool) and isinstance(value, Real):
            with suppress(OverflowError):  # a whole number that no float is large enough for
                number = float(value)
        if not math.isfinite(number):
            raise _refused(name, "a finite number", value)
        if not self.low <= number <= self.high:
            raise InputError(f"{name}: expected {self._range()}, got {self._shown(number)}")
        return number

    def _range(self) -> str:
        """The range for a message: of angles in degrees too, which those at a command line gave."""
        if self.unit != "rad":
            return self.accepted
        return f"{self.accepted} ({math.degrees(self.low):g} to {math.degrees(self.high):g} deg)"

    def _shown(self, number: float) -> str:
        degrees = f" ({math.degrees(number):g} deg)" if self.unit == "rad" else ""
        return f"{number:g}{degrees}"


@dataclass(frozen=True)
class Whole(FieldSpec):
    """A whole number in a range."""

    low: int = 0  # the range, both included; `high` None: no end
    high: int | None = None  # the range, both included; `high` None: no end

    @property
    def accepted(self) -> str:
        return "" if self.high is None else f"{self.low} to {self.high}"

    def checked(self, name: str, value: Any) -> int:
        if isinstance(value, bool) or not isinstance(value, Integral) or int(value) < self.low:
            raise _refused(name, f"a whole number from {self.low} on", value)
        if self.high is not None and int(value) > self.high:
            raise InputError(f"{name}: expected {self.accepted}, got {value}")
        return int(value)


@dataclass(frozen=True)
class Flag(FieldSpec):
    """Yes or no."""

    def checked(self, name: str, value: Any) -> bool:
        plain = value.item() if getattr(value, "ndim", None) == 0 else value
        if not isinstance(plain, bool):
            raise _refused(name, "true or false", value)
        return plain


@dataclass(frozen=True)
class Name(FieldSpec):
    """A name, of the choices that are checked elsewhere."""

    longest: int = _LONGEST_NAME  # characters; a path may have more than a name in a list

    def checked(self, name: str, value: Any) -> str:
        if not isinstance(value, str) or not value or not value.isprintable():
            raise _refused(name, "a name", value)
        if len(value) > self.longest:
            raise _refused(name, f"a name of at most {self.longest} characters", value)
        return value


@cache
def field_specs(kind: type) -> dict[str, FieldSpec]:
    """Field -> its specification, of a dataclass that states one beside each type."""
    hints = get_type_hints(kind, include_extras=True)
    return {name: hint.__metadata__[0] for name, hint in hints.items()}


def check_fields(instance: Any) -> None:
    """Check every field of a frozen dataclass in its `__post_init__`; a default None is none.
    Raises `InputError`: a value of another type or out of range.
    """
    kind: Any = type(instance)
    specs = field_specs(kind)
    for field in fields(instance):
        value = getattr(instance, field.name)
        if value is not None or field.default is not None:
            value = specs[field.name].checked(field.name.replace("_", " "), value)
            object.__setattr__(instance, field.name, value)


def _refused(name: str, expected: str, value: Any) -> InputError:
    return InputError(f"{name}: expected {expected}, got {reprlib.repr(value)}")
