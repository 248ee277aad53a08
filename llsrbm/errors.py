"""Errors that a user can cause, under one base class."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any


class Error(Exception):
    """Base of every error a user can cause.

    The message is one line and says what was wrong, what would be accepted, and where.
    """


class InputError(Error):
    """A value, a name or a combination of values that cannot be used (exit status 2)."""


class NoFooting(InputError):
    """A jump that would put feet onto, or too near to, what it is to pass over."""


class UnusableStart(InputError):
    """A plan that another one cannot be started from."""


class RobotFileError(InputError):
    """A robot file that cannot be read or that contradicts its URDF."""


class FileFormatError(InputError):
    """A file that is not what its reader expects."""


@dataclass(frozen=True)
class Stop:
    """A limiting constraint of a plan, and the limit in it that would have to change."""

    constraint: str  # its name (`llsrbm.planning.problem.constraints`)
    phase: str  # name of the schedule's phase
    time: float  # s; where it is worst
    # By how much, in `unit`: the limit would have to change, or, where there is no limit, the
    # constraint is violated.
    amount: float
    unit: str
    limit: str | None = None  # name (`llsrbm.planning.problem.limits`); None: none alone would help
    title: str = ""  # the limit in words
    value: float = 0.0  # of the limit, in `unit`
    needed: float = 0.0  # the value it would have to have
    together: bool = False  # whether the other stops have to be removed as well; else any one does
    detail: str = ""  # the joint, where, and how much, of a limit of the drives; "" of all others

    def __str__(self) -> str:
        if self.detail:
            return self.detail
        where = f"in {self.phase} at {self.time:.2f} s"
        if self.limit is None:
            return f"{self.constraint} is violated by {self.amount:.3g} {self.unit} {where}"
        unit = "" if self.unit == "1" else f" {self.unit}"
        return (
            f"{self.title} ({self.limit}) would have to be {self.needed:.3g}{unit} {where}; "
            f"the limit is {self.value:.3g}{unit}"
        )


def printable(text: str, longest: int = 60) -> str:
    """The beginning of a stranger's text, in one line without control codes, for messages."""
    shown = "".join(letter if letter.isprintable() else "?" for letter in text[: longest + 1])
    return shown if len(shown) <= longest else f"{shown[: longest - 3]}..."


def require(purpose: str, extra: str, *modules: str) -> None:
    """Raise `InputError` unless all modules, of an `extra` of this package, are installed.

    `purpose` begins the message, for example "sweeps need Dask".
    """
    if any(find_spec(module) is None for module in modules):
        raise InputError(f"{purpose}: pip install 'llsrbm[{extra}]'")


class NotConverged(Error):
    """No plan satisfies every constraint: the last iterate, `plan`; `stops`, the worst first."""

    def __init__(self, message: str, plan: Any, stops: tuple[Stop, ...] = ()) -> None:
        super().__init__(message, plan, stops)  # all of them, for pickle
        self.plan, self.stops = plan, stops

    def __str__(self) -> str:
        return str(self.args[0])


class Cancelled(Error):
    """The computation was stopped on request before it had a result."""
