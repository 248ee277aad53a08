"""A file that a visitor has opened, as it goes from a computing process to the server.

Designs are of robots, models and types that the page has, never of a path.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from llsrbm import models
from llsrbm.errors import InputError
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.request import jump_types
from llsrbm.request.design import Design, load_design
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot, names


@dataclass(frozen=True, eq=False)
class States:
    """A motion of another tool's file, as it goes from one process to another."""

    robot: str  # name of the robot that moves
    values: Mapping[str, Any]  # the other fields of `WholeBodyMotion`

    @staticmethod
    def of(motion: WholeBodyMotion, robot: str) -> States:
        """Everything but the robot itself, which every process loads once."""
        names = (field.name for field in fields(motion) if field.name != "robot")
        return States(robot, {name: getattr(motion, name) for name in names})

    def motion(self) -> WholeBodyMotion:
        """The motion, of the robot as this process has it."""
        return WholeBodyMotion(robot=load_robot(self.robot), **self.values)


@dataclass(frozen=True, eq=False)
class OpenedFile:
    """A file that can be shown."""

    name: str  # of the file, in one printable line
    holds: Design | Plan | Rollout | States  # what is in it
    remarks: tuple[str, ...] = ()  # sentences on what is not as one would expect

    @property
    def is_alone(self) -> bool:
        """Whether it is a motion without a plan, for looking."""
        return isinstance(self.holds, States)

    @property
    def robot(self) -> str:
        """Name of its robot."""
        return self.holds.robot if isinstance(self.holds, States) else self.holds.jump.robot


def uploaded_design(name: str, content: bytes) -> Design:
    """The design in a file; raises `InputError` of none, or of one that the page does not offer."""
    design = load_design(content, name=name)
    check_offered(design.jump, f"{name}: jump")
    return design


def check_offered(jump: Jump, where: str) -> None:
    """Raise `InputError` unless robot, model and type are among those that the page has.

    A file's path works on the command line; a visitor shall not open files of this machine.
    """
    for key, value, valid in (
        ("robot", jump.robot, names()),
        ("model", jump.model, tuple(models.MODELS)),
        ("type", jump.type, tuple(jump_types.names())),
    ):
        if value not in valid:
            raise InputError(
                f"{where}.{key}: expected one of {', '.join(valid)}, got {value!r:.80}"
            )
