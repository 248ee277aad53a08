"""Everything that can go wrong because of what a user gave, under one base class."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from llsrbm.motion.plan import Plan


class Error(Exception):
    """Base of every error a user can cause.

    The message is one line and says what was wrong, what would be accepted, and where.
    """


class InputError(Error):
    """A value, a name or a combination of values that cannot be used (exit status 2)."""


class NoFooting(InputError):
    """A jump that would put feet onto, or too near to, what it is to pass over."""


class RobotFileError(InputError):
    """A robot file that cannot be read or that contradicts its URDF."""


class FileFormatError(InputError):
    """A file that is not what its reader expects."""


@dataclass(frozen=True)
class Stop:
    """What stops a plan: a constraint, and the limit in it that would have to be another.

    Attributes:
        constraint: its name (`llsrbm.planning.problem.constraints`).
        phase: name of the schedule's phase; time: s; where it is worst.
        amount: by how much, in `unit`: the limit would have to change, or, where there is no
            limit, the constraint is violated.
        limit: its name (`llsrbm.planning.problem.limits`); None: no limit alone would help.
        title: the limit in words.
        value: what the limit is, in `unit`; needed: what it would have to be.
        together: whether the other stops have to be removed as well; else any one does.
        detail: the joint, where, and how much, of a limit of the drives; "" of all others.
    """

    constraint: str
    phase: str
    time: float
    amount: float
    unit: str
    limit: str | None = None
    title: str = ""
    value: float = 0.0
    needed: float = 0.0
    together: bool = False
    detail: str = ""

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
    """As much of a stranger's text as fits into a message, in one line without control codes."""
    shown = "".join(letter if letter.isprintable() else "?" for letter in text[: longest + 1])
    return shown if len(shown) <= longest else f"{shown[: longest - 3]}..."


def require(purpose: str, extra: str, *modules: str) -> None:
    """Raise `InputError` unless all modules are installed.

    Args:
        purpose: begins the message, for example "sweeps need Dask".
        extra: of this package, with which they are installed.
        modules: importable names.
    """
    if any(find_spec(module) is None for module in modules):
        raise InputError(f"{purpose}: pip install 'llsrbm[{extra}]'")


class NotConverged(Error):
    """The planner stopped without satisfying every constraint.

    Attributes:
        plan: the last iterate, with its violations, to look at.
        stops: what stops it, the worst first.
    """

    def __init__(self, message: str, plan: Plan, stops: tuple[Stop, ...] = ()) -> None:
        super().__init__(message)
        self.plan, self.stops = plan, stops


class Cancelled(Error):
    """The computation was stopped on request before it had a result."""
