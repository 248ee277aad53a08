"""The options that say what jump is wanted: one for each field of `Jump`."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from functools import wraps
from typing import Any, get_type_hints

import typer

from llsrbm.commands import options
from llsrbm.request.jump import ASKABLE, Jump

ANGLES = frozenset({"twist", "roll", "pitch"})  # degrees on the command line

_OF_THE_TYPE = "the type's"  # what an option is that only some types ask for
_HELP = {
    "robot": "A name (see `llsrbm robots`) or a robot file's path.",
    "model": "See `llsrbm models`.",
    "twist": "Turn to the left.",
    "forward": "Displacement along x.",
    "lateral": "Displacement to the left.",
    "height": "Of the landing surface.",
    "type": "Of jump: a name (see `llsrbm types`) or the path of a type's TOML file.",
    "roll": "Whole turns about the body's x axis: 360 is a roll to the right.",
    "pitch": "Whole turns about the body's y axis: 360 is a front flip, -360 a back flip.",
    "speed": "Forward, at the start.",
    "end_speed": "Forward, at the end.",
    "hops": "Jumps in a row, each as far as the displacement says.",
}
_SYMBOLS = dict.fromkeys(ANGLES, "DEG") | {
    **dict.fromkeys(("forward", "lateral", "height"), "M"),
    **dict.fromkeys(("speed", "end_speed"), "M/S"),
    "hops": "N",
}


def with_jump_options(command: Callable[..., int]) -> Callable[..., int]:
    """The command with the options of a jump in place of its parameter `asked`.

    Args:
        command: its first parameter is `context`; as `asked` it gets those fields of a `Jump`
            whose options stand on the command line, name -> value, in the library's units.
    """
    names = [field.name for field in fields(Jump)]

    @wraps(command)
    def called(context: typer.Context, **arguments: Any) -> int:
        values = {name: arguments.pop(name) for name in names}
        asked = {
            name: math.radians(value) if name in ANGLES else value
            for name, value in values.items()
            if options.is_given(context, name)
        }
        return command(context, **arguments, asked=asked)

    parameters: list[inspect.Parameter] = []
    for parameter in inspect.signature(command, eval_str=True).parameters.values():
        parameters += _parameters() if parameter.name == "asked" else [parameter]
    called.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return called


def requested_jump(asked: Mapping[str, Any], jump: Jump | None = None) -> Jump:
    """A request with other values in the fields that are asked for.

    Where a type is asked for, the fields that only some types have become that type's defaults.

    Args:
        asked: as `with_jump_options` hands it on.
        jump: what is asked for without any option; None: the default jump.

    Raises:
        InputError: a value that cannot be, or no such type.
    """
    changed = replace(jump or Jump(), **asked)
    if "type" not in asked:
        return changed
    from llsrbm.request.jump_types import with_defaults  # slow to import

    return with_defaults(changed, asked)


def in_words(jump: Jump) -> str:
    """The request in one line, in the command line's units."""
    plain = Jump()
    told = [] if jump.type == plain.type else [jump.type]
    told.append(
        f"twist {math.degrees(jump.twist):.0f} deg, forward {jump.forward:.2f} m, lateral "
        f"{jump.lateral:.2f} m, height {jump.height:.2f} m"
    )
    told += [
        f"{name} {math.degrees(turn):.0f} deg"
        for name, turn in (("roll", jump.roll), ("pitch", jump.pitch))
        if turn
    ]
    told += [
        f"{name} {speed:.2f} m/s"
        for name, speed in (("speed", jump.speed), ("end speed", jump.end_speed))
        if speed
    ]
    if jump.hops != plain.hops:
        told.append(f"{jump.hops} hops")
    return f"{jump.robot}, {jump.model}: {', '.join(told)}"


def _parameters() -> list[inspect.Parameter]:
    """An option for each field, as typer reads them from a function's signature."""
    types, parameters = get_type_hints(Jump), []
    for field in fields(Jump):
        of_the_type = field.name in ASKABLE
        option = typer.Option(
            None if of_the_type else field.default,
            metavar=_SYMBOLS.get(field.name),
            help=_HELP[field.name],
            show_default=_OF_THE_TYPE if of_the_type else True,
        )
        kind = types[field.name]
        parameters.append(
            inspect.Parameter(
                field.name,
                inspect.Parameter.POSITIONAL_OR_KEYWORD,
                default=option,
                annotation=kind | None if of_the_type else kind,
            )
        )
    return parameters
