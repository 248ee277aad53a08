"""Jump types on the page: those that a robot can do, and a request of another type."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

from llsrbm import jump_types
from llsrbm.errors import InputError
from llsrbm.jump import Jump
from llsrbm.jump_types import JumpType
from llsrbm.robots import Robot

_SILENT: dict[str, Any] = {
    field.name: field.default for field in fields(Jump) if field.name in jump_types.ASKABLE
}


def types_offered(robot: Robot) -> dict[str, JumpType]:
    """Name -> type of those whose feet the robot has, the default first."""
    return {name: kind for name, kind in jump_types.names().items() if _has_feet_of(robot, kind)}


def title_of_type(name: str) -> str:
    """As in menus and messages; the name itself of a type that is no preset."""
    known = jump_types.names()
    return known[name].title if name in known else name


def with_type(jump: Jump, name: str) -> Jump:
    """The request as one of another type.

    What that type states for silent requests is taken; of what it does not ask for nothing stays.

    Args:
        jump: the request; robot, model and landing place stay, unless the type states one.
        name: of a preset.
    """
    stated = {**_SILENT, **jump_types.load_type(name).defaults}
    return replace(jump, type=name, **stated)


def _has_feet_of(robot: Robot, kind: JumpType) -> bool:
    try:
        kind.schedule(robot)
    except InputError:
        return False
    return True
