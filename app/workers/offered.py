"""Designs that a browser sends: of robots, models and types that the page has, never of a path."""

from __future__ import annotations

from llsrbm import models
from llsrbm.errors import InputError
from llsrbm.request import jump_types
from llsrbm.request.design import Design, load_design
from llsrbm.request.jump import Jump
from llsrbm.robots import names


def uploaded_design(name: str, content: bytes) -> Design:
    """The design in an uploaded file.

    Args:
        name: of the file, as the browser has it.
        content: of the file.

    Raises:
        InputError: it is no design, or one of a robot, model or type that is not on the page.
    """
    design = load_design(content, name=name)
    check_offered(design.jump, f"{name}: jump")
    return design


def check_offered(jump: Jump, where: str) -> None:
    """Raise `InputError` unless robot, model and type are among those that the page has.

    A file's path works on the command line; a visitor shall not open files of this machine.
    """
    for key, value, valid in (
        ("robot", jump.robot, names()),
        ("model", jump.model, models.names()),
        ("type", jump.type, tuple(jump_types.names())),
    ):
        if value not in valid:
            raise InputError(
                f"{where}.{key}: expected one of {', '.join(valid)}, got {value!r:.80}"
            )
