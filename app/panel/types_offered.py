"""Jump types on the page: those that a robot can do, and a request of another type."""

from __future__ import annotations

from dataclasses import replace

from llsrbm import jump_types
from llsrbm.errors import InputError
from llsrbm.jump import Jump
from llsrbm.jump_types import JumpType, with_defaults
from llsrbm.robots import Robot


def types_offered(robot: Robot) -> dict[str, JumpType]:
    """Name -> type of those whose feet the robot has, the default first."""
    return {name: kind for name, kind in jump_types.names().items() if _has_feet_of(robot, kind)}


def title_of_type(name: str) -> str:
    """As in menus and messages; the name itself of a type that is no preset."""
    known = jump_types.names()
    return known[name].title if name in known else name


def with_type(jump: Jump, name: str) -> Jump:
    """The request as one of another type, with that type's defaults; the landing place stays."""
    return with_defaults(replace(jump, type=name))


def _has_feet_of(robot: Robot, kind: JumpType) -> bool:
    try:
        kind.schedule(robot)
    except InputError:
        return False
    return True
