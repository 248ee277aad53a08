"""What there is to say about a field of a request, said once: meaning, unit, range and check.

A dataclass states it with the type, `board: Annotated[float, Number(...)]`. Messages, options of
the command line and files take it from there.
"""

from __future__ import annotations

import math
import reprlib
from abc import ABC, abstractmethod
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from numbers import Integral, Real
from typing import Any, get_type_hints

from llsrbm.errors import InputError

_LONGEST_NAME = 100  # characters; messages and pages show names in a line


@dataclass(frozen=True)
class Meaning(ABC):
    """What a field means and accepts.

    Attributes:
        help: one sentence without its full stop.
        symbol: stands for the value where a usage is shown, "M"; "": its type does.
    """

    help: str
    symbol: str = ""

    @property
    def accepted(self) -> str:
        """The range with its unit, "0 to 1 m"; "" where the type says it all."""
        return ""

    @abstractmethod
    def checked(self, name: str, value: Any) -> Any:
        """The value as the field holds it, a scalar of NumPy as Python's own.

        Args:
            name: of the field, for messages.
            value: what was given.

        Raises:
            InputError: of another type, or out of range.
        """


@dataclass(frozen=True)
class Number(Meaning):
    """A real number in a range.

    Attributes:
        low, high: the range, both included.
        unit: of the value and of the range.
    """

    low: float = -math.inf
    high: float = math.inf
    unit: str = ""

    @property
    def accepted(self) -> str:
        """See `Meaning.accepted`."""
        return f"{self.low:g} to {self.high:g} {self.unit}".rstrip()

    def checked(self, name: str, value: Any) -> float:
        """See `Meaning.checked`."""
        number = math.nan
        if not isinstance(value, bool) and isinstance(value, Real):
            with suppress(OverflowError):  # a whole number that no float is large enough for
                number = float(value)
        if not math.isfinite(number):
            raise _refused(name, "a finite number", value)
        if not self.low <= number <= self.high:
            raise InputError(f"{name}: expected {self.accepted}, got {number:g}")
        return number


@dataclass(frozen=True)
class Whole(Meaning):
    """A whole number from 0 on."""

    def checked(self, name: str, value: Any) -> int:
        """See `Meaning.checked`."""
        if isinstance(value, bool) or not isinstance(value, Integral) or int(value) < 0:
            raise _refused(name, "a whole number from 0 on", value)
        return int(value)


@dataclass(frozen=True)
class Flag(Meaning):
    """Yes or no."""

    def checked(self, name: str, value: Any) -> bool:
        """See `Meaning.checked`."""
        plain = value.item() if getattr(value, "ndim", None) == 0 else value
        if not isinstance(plain, bool):
            raise _refused(name, "true or false", value)
        return plain


@dataclass(frozen=True)
class Name(Meaning):
    """One of several things that are found by their names; which there are is checked elsewhere."""

    def checked(self, name: str, value: Any) -> str:
        """See `Meaning.checked`."""
        if not isinstance(value, str) or not value or not value.isprintable():
            raise _refused(name, "a name", value)
        if len(value) > _LONGEST_NAME:
            raise _refused(name, f"a name of at most {_LONGEST_NAME} characters", value)
        return value


@cache
def meanings(kind: type) -> dict[str, Meaning]:
    """What the fields of a dataclass mean: name -> what stands beside its type."""
    hints = get_type_hints(kind, include_extras=True)
    return {name: hint.__metadata__[0] for name, hint in hints.items()}


def _refused(name: str, expected: str, value: Any) -> InputError:
    return InputError(f"{name}: expected {expected}, got {reprlib.repr(value)}")
