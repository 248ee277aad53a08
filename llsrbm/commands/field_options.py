"""Options of a request: `--design`, and one for each field of a `Jump` or a `Scenario`.

Angles are degrees on the command line.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from functools import wraps
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints

import typer

from llsrbm.commands import options
from llsrbm.request.jump import TYPE_PARAMETERS, Jump
from llsrbm.request.messages import FieldSpec, Number, field_specs
from llsrbm.request.push import PushList, parse_push
from llsrbm.request.scenario import Scenario

if TYPE_CHECKING:
    from llsrbm.request.design import Design

DesignOption = Annotated[
    str | None,
    typer.Option(
        "--design",
        metavar="FILE",
        help="A design's file, or a name of `llsrbm designs`; other options override it.",
    ),
]

_PARAMETERS = {"solver": "qp_solver"}  # `--solver` is the planner's
_FLAGS = {"half_board": "--half-board/--whole-board", "pushes": "--push"}
_OF_THE_TYPE = "the type's"  # default of an option that only some jump types have


def with_jump_options(command: Callable[..., int]) -> Callable[..., int]:
    """The command with the options of a jump in place of its parameter `requested`.

    Args:
        command: its first parameter is `context`; `requested` becomes those fields of a `Jump`
            whose options stand on the command line, name -> value, in the library's units.
    """
    return _with_options(command, Jump, "requested")


def with_scenario_options(command: Callable[..., int]) -> Callable[..., int]:
    """Likewise with the options of a scenario in place of its parameter `conditions`."""
    return _with_options(command, Scenario, "conditions")


def requested_jump(requested: Mapping[str, Any], jump: Jump | None = None) -> Jump:
    """A jump with other values in the requested fields.

    With another type, the fields that only some types have become that type's defaults.

    Args:
        requested: as `with_jump_options` passes it.
        jump: to be changed; None: the default jump.

    Raises:
        InputError: an impossible value, or no such type.
    """
    changed = replace(jump or Jump(), **requested)
    if "type" not in requested:
        return changed
    from llsrbm.request.jump_types import with_defaults  # slow to import

    return with_defaults(changed, requested)


def requested_design(name_or_path: str | None, requested: Mapping[str, Any]) -> Design:
    """The design that was named, its jump as the options of a command line change it.

    Args:
        name_or_path: as `llsrbm.request.design.find_design` takes it; None: only the jump.
        requested: as `requested_jump` takes it.
    """
    from llsrbm.request.design import Design, find_design

    if name_or_path is None:
        return Design(requested_jump(requested))
    design = find_design(name_or_path)
    return replace(design, jump=requested_jump(requested, design.jump))


def is_angle(name: str) -> bool:
    """True if a field of a jump is an angle, which the command line has in degrees."""
    spec = field_specs(Jump)[name]
    return isinstance(spec, Number) and spec.unit == "rad"


def in_words(jump: Jump) -> str:
    """The request in one line, in the command line's units."""
    plain = Jump()
    words = [] if jump.type == plain.type else [jump.type]
    words.append(
        f"twist {math.degrees(jump.twist):.0f} deg, forward {jump.forward:.2f} m, lateral "
        f"{jump.lateral:.2f} m, height {jump.height:.2f} m"
    )
    words += [
        f"{name} {math.degrees(turn):.0f} deg"
        for name, turn in (("roll", jump.roll), ("pitch", jump.pitch))
        if turn
    ]
    words += [
        f"{name} {speed:.2f} m/s"
        for name, speed in (("speed", jump.speed), ("end speed", jump.end_speed))
        if speed
    ]
    if jump.hops != plain.hops:
        words.append(f"{jump.hops} hops")
    return f"{jump.robot}, {jump.model}: {', '.join(words)}"


def _with_options(command: Callable[..., int], kind: type, parameter: str) -> Callable[..., int]:
    """The command with an option for each field of `kind` in place of one parameter."""
    specs = field_specs(kind)
    field_of = {_parameter(kind, name): name for name in specs}

    @wraps(command)
    def called(context: typer.Context, **arguments: Any) -> int:
        given = {name: arguments.pop(name) for name in field_of}
        values = {
            field_of[name]: _in_library_units(specs[field_of[name]], value)
            for name, value in given.items()
            if options.is_given(context, name)
        }
        return command(context, **arguments, **{parameter: values})

    parameters: list[inspect.Parameter] = []
    for each in inspect.signature(command, eval_str=True).parameters.values():
        parameters += _parameters(kind) if each.name == parameter else [each]
    called.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return called


def _parameter(kind: type, field: str) -> str:
    return _PARAMETERS.get(field, field) if kind is Scenario else field


def _in_library_units(spec: FieldSpec, value: Any) -> Any:
    if isinstance(spec, PushList):
        return tuple(map(parse_push, value))
    return math.radians(value) if isinstance(spec, Number) and spec.unit == "rad" else value


def _parameters(kind: Any) -> list[inspect.Parameter]:
    """An option for each field, as typer reads them from a function's signature."""
    types, specs, parameters = get_type_hints(kind), field_specs(kind), []
    for field in fields(kind):
        spec, default, annotation = specs[field.name], field.default, types[field.name]
        accepted = f" ({spec.accepted})" if spec.accepted else ""
        shown: bool | str = True
        if isinstance(spec, PushList):
            accepted, default, annotation = f"{accepted}; may be repeated", [], list[str]
        elif kind is Jump and field.name in TYPE_PARAMETERS:
            default, annotation, shown = None, annotation | None, _OF_THE_TYPE
        option = typer.Option(
            default,
            *([_FLAGS[field.name]] if field.name in _FLAGS else []),
            metavar=spec.symbol or None,
            help=f"{spec.help}{accepted}.",
            show_default=shown,
        )
        parameters.append(
            inspect.Parameter(
                _parameter(kind, field.name),
                inspect.Parameter.POSITIONAL_OR_KEYWORD,
                default=option,
                annotation=annotation,
            )
        )
    return parameters
