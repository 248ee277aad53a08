"""Everything that can go wrong because of what a user gave, under one base class."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from llsrbm.trajectory.plan import Plan


class Error(Exception):
    """Base of every error a user can cause.

    The message is one line and says what was wrong, what would be accepted, and where.
    """


class InputError(Error):
    """A value, a name or a combination of values that cannot be used (exit status 2)."""


class RobotFileError(InputError):
    """A robot file that cannot be read or that contradicts its URDF."""


class FileFormatError(InputError):
    """A file that is not what its reader expects."""


class NotConverged(Error):
    """The planner stopped without satisfying every constraint.

    Attributes:
        plan: the last iterate, with its violations, to look at.
    """

    def __init__(self, message: str, plan: Plan) -> None:
        super().__init__(message)
        self.plan = plan


class Cancelled(Error):
    """The computation was stopped on request before it had a result."""
