"""Jump types on the page: those that a robot can do, and a request of another type."""

from __future__ import annotations

from dataclasses import replace

from llsrbm.errors import InputError
from llsrbm.request import jump_types
from llsrbm.request.jump import Jump
from llsrbm.request.jump_types import JumpType, with_defaults
from llsrbm.robots import Robot


def types_offered(robot: Robot) -> dict[str, JumpType]:
    """Name -> type of those that the robot can do, the default first.

    It has their feet, and makes the turns that they make if nothing is said of them.
    """
    return {
        name: kind
        for name, kind in jump_types.names().items()
        if _has_feet_of(robot, kind) and _turns_as(robot, kind)
    }


def title_of_type(name: str) -> str:
    """As in menus and messages; the name itself of a type that is no preset."""
    known = jump_types.names()
    return known[name].title if name in known else name


def with_type(jump: Jump, name: str) -> Jump:
    """The request as one of another type, with that type's defaults; the landing place stays."""
    return with_defaults(replace(jump, type=name))


def _turns_as(robot: Robot, kind: JumpType) -> bool:
    turned = {name for name in ("pitch", "roll") if kind.defaults.get(name)}
    return turned <= set(robot.file.turning_axes)


def _has_feet_of(robot: Robot, kind: JumpType) -> bool:
    try:
        kind.schedule(robot)
    except InputError:
        return False
    return True
