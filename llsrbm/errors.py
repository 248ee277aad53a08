"""Errors that a user can cause, under one base class."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

from llsrbm.number_text import short


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
class JointNeed:
    """Load or angle of a joint that a jump needs, and the one that a plan may use there."""

    joint: str
    needed: float  # in `unit`
    has: float  # likewise
    unit: str  # Nm, rad/s or rad; of joints that slide N, m/s or m
    when: str  # in words

    def __str__(self) -> str:
        needed, has = number_pair(self.needed, self.has)
        return f"{self.joint} needs {needed} {self.unit} {self.when}, it has {has}"


@dataclass(frozen=True)
class Stop:
    """A limiting constraint of a plan, and the limit in it that would have to change."""

    constraint: str  # its name (`llsrbm.planning.problem.constraints`)
    phase: str  # name of the schedule's phase
    time: float  # s; where it is worst
    # By how much, in `unit`: the limit would have to change, or, where there is no limit, the
    # constraint is violated; 0 where that is not known.
    amount: float
    unit: str
    limit: str | None = None  # name (`llsrbm.planning.problem.limits`); None: none alone would help
    title: str = ""  # the limit in words, or what is violated
    value: float = 0.0  # of the limit, in `unit`
    needed: float = 0.0  # the value it would have to have
    together: bool = False  # whether the other stops have to be removed as well; else any one does
    demand: JointNeed | None = None  # on a joint, of a limit of drives or stops; None of all others

    def __str__(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        if self.demand is not None:
            if self.amount == 0:
                of = self.demand
                return f"{of.joint} is at its limit of {of.has:.3g} {of.unit} {of.when}"
            return str(self.demand)
        where = f"in {self.phase} at {self.time:.2f} s"
        if self.limit is None:
            what = self.title or f"{self.constraint} is violated"
            if self.amount == 0:
                return f"{what} {where}"
            return f"{what} by {self.amount:.3g} {self.unit} {where}"
        if self.amount == 0:
            return f"the {self.title} is at its limit of {self.value:.3g}{unit}"
        needed, value = number_pair(self.needed, self.value)
        return f"the {self.title} would have to be {needed}{unit} {where}, it is {value}"


def number_pair(one: float, other: float) -> tuple[str, str]:
    """Two numbers in as few digits, from two on, as tell them apart."""
    for digits in range(2, 7):
        pair = f"{one:.{digits}g}", f"{other:.{digits}g}"
        if pair[0] != pair[1]:
            break
    return short(float(pair[0])), short(float(pair[1]))


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
    """No plan satisfies every constraint.

    Attributes:
        plan: the last iterate; or `nearest`, where that was found without one of the request.
        stops: the limits that stop the jump, the most important first.
        nearest: the plan of the nearest jump that can be done; None if there is none.
        reason: one sentence, of at most two limits; "" if none is known.
    """

    def __init__(
        self,
        message: str,
        plan: Any,
        stops: tuple[Stop, ...] = (),
        nearest: Any = None,
        reason: str = "",
    ) -> None:
        super().__init__(message, plan, stops, nearest, reason)  # all of them, for pickle
        self.plan, self.stops, self.nearest, self.reason = plan, stops, nearest, reason

    def __str__(self) -> str:
        return str(self.args[0])

    def with_plans(self, plan: Any, nearest: Any) -> NotConverged:
        """The same with another last iterate and another plan of the nearest jump."""
        return NotConverged(str(self), plan, self.stops, nearest, self.reason)


class Cancelled(Error):
    """The computation was stopped on request before it had a result."""
