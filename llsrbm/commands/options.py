"""Options that commands share: how to plan, where results go."""

from __future__ import annotations

import math
from dataclasses import fields
from pathlib import Path
from typing import Annotated

import typer

from llsrbm.errors import InputError
from llsrbm.request.jump import Jump
from llsrbm.request.tuning import Tuning

Robot = Annotated[str, typer.Option(help="A name (see `llsrbm robots`) or a robot file's path.")]
Planner = Annotated[str, typer.Option(help="fatrop or ipopt.")]
Out = Annotated[Path | None, typer.Option(metavar="FILE", help="Write the result here (npz).")]
AsJson = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on stdout, the rest on stderr.")
]

Weights = Annotated[
    list[str] | None,
    typer.Option("--weight", metavar="NAME=VALUE", help="See `llsrbm tuning`; may be repeated."),
]
Limits = Annotated[
    list[str] | None,
    typer.Option("--limit", metavar="NAME=VALUE", help="See `llsrbm tuning`; may be repeated."),
]

PLANNING = ("design", *(field.name for field in fields(Jump)), "solver", "weight", "limit")
"""Parameters of the options of planning."""


def is_given(context: typer.Context, name: str) -> bool:
    """True if a parameter of a command stands on the command line."""
    source = context.get_parameter_source(name)
    return source is not None and source.name != "DEFAULT"


def option(name: str) -> str:
    """The option of a parameter: "--end-speed"."""
    return f"--{name.replace('_', '-')}"


def requested_tuning(tuning: Tuning, weight: list[str] | None, limit: list[str] | None) -> Tuning:
    """A design's weights and limits as the options change them.

    Raises:
        InputError: not NAME=VALUE. Names and ranges are checked when something is planned.
    """
    from llsrbm.planning.problem.limits import limit_unit

    weights = dict(_assignment("--weight", given) for given in weight or [])
    limits = dict(_assignment("--limit", given) for given in limit or [])
    for name in limits:
        if limit_unit(name) == "rad":  # degrees on the command line
            limits[name] = math.radians(limits[name])
    return Tuning({**tuning.weights, **weights}, {**tuning.limits, **limits})


def _assignment(option: str, given: str) -> tuple[str, float]:
    name, _, value = given.partition("=")
    try:
        return name.strip(), float(value)
    except ValueError:
        raise InputError(
            f"{option} {given}: expected NAME=VALUE with a number; `llsrbm tuning` lists the names"
        ) from None
