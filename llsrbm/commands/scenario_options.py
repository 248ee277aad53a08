"""The options that say what a simulation is asked for: one for each field of `Scenario`."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import fields
from functools import wraps
from typing import Any, get_type_hints

import typer

from llsrbm.commands import options
from llsrbm.request.fields import meanings
from llsrbm.request.push import PushList, parse_push
from llsrbm.request.scenario import Scenario

_PARAMETERS = {"solver": "qp_solver"}  # `--solver` is the planner's
_FLAGS = {"half_board": "--half-board/--whole-board", "pushes": "--push"}


def with_scenario_options(command: Callable[..., int]) -> Callable[..., int]:
    """The command with the options of a scenario in place of its parameter `fields`.

    Args:
        command: its first parameter is `context`; as `fields` it gets those whose options
            stand on the command line, name -> value, for `Scenario.but`.
    """
    of_field = {_PARAMETERS.get(field.name, field.name): field.name for field in fields(Scenario)}

    @wraps(command)
    def called(context: typer.Context, **arguments: Any) -> int:
        values = {name: arguments.pop(name) for name in of_field}
        given = {of_field[n]: v for n, v in values.items() if options.is_given(context, n)}
        if "pushes" in given:
            given["pushes"] = tuple(map(parse_push, given["pushes"]))
        return command(context, **arguments, fields=given)

    parameters: list[inspect.Parameter] = []
    for parameter in inspect.signature(command, eval_str=True).parameters.values():
        parameters += _parameters() if parameter.name == "fields" else [parameter]
    called.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return called


def _parameters() -> list[inspect.Parameter]:
    """An option for each field, as typer reads them from a function's signature."""
    types, parameters = get_type_hints(Scenario), []
    for field in fields(Scenario):
        meaning = meanings(Scenario)[field.name]
        flags = [_FLAGS[field.name]] if field.name in _FLAGS else []
        accepted = f" ({meaning.accepted})" if meaning.accepted else ""
        several = isinstance(meaning, PushList)
        if several:
            accepted += "; may be repeated"
        option = typer.Option(
            [] if several else field.default,
            *flags,
            metavar=meaning.symbol or None,
            help=f"{meaning.help}{accepted}.",
        )
        parameters.append(
            inspect.Parameter(
                _PARAMETERS.get(field.name, field.name),
                inspect.Parameter.POSITIONAL_OR_KEYWORD,
                default=option,
                annotation=list[str] if several else types[field.name],
            )
        )
    return parameters
