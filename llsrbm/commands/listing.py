"""`llsrbm robots | models | types | designs | tuning`: lists of names."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from llsrbm.commands import console, options

if TYPE_CHECKING:
    from llsrbm.request.jump_types import JumpType


def robots_command() -> int:
    """List the robots that come with the project, and how their drives are known."""
    from llsrbm.robots import read_robot_file
    from llsrbm.robots.drives.stated import known_in_words
    from llsrbm.robots.schema import robot_files

    files = {name: read_robot_file(path) for name, path in robot_files().items()}
    console.print_table(
        {name: f"{file.title} (drives: {known_in_words(file)})" for name, file in files.items()}
    )
    return console.DONE


def models_command() -> int:
    """List the models of the robot's inertia in the planner."""
    from llsrbm.models import MODELS

    console.print_table({name: model.summary for name, model in MODELS.items()})
    return console.DONE


def types_command() -> int:
    """List the types of jumps, with the options that each takes beside where to land."""
    from llsrbm.request import jump_types

    rows = {
        name: f"{kind.title}: {kind.summary}{_own_options(kind)}"
        for name, kind in jump_types.names().items()
    }
    console.print_table(rows)
    return console.DONE


def _own_options(kind: JumpType) -> str:
    """The options that a type takes, with its defaults: " (--pitch -360, --roll)"."""
    taken = []
    for name in kind.parameters:
        value = kind.defaults.get(name)
        if value is not None and options.is_angle(name):
            value = math.degrees(value)
        taken.append(options.option(name) + ("" if value is None else f" {value:g}"))
    return f" ({', '.join(taken)})" if taken else ""


def designs_command() -> int:
    """List the designs that come with the project."""
    from llsrbm.request.design import examples

    console.print_table({name: design.title for name, design in examples().items()})
    return console.DONE


def tuning_command(robot: options.Robot = "anymal") -> int:
    """List the weights and limits that a request may change, with the robot's own values."""
    from llsrbm.number_text import aligned
    from llsrbm.planning.problem.costs import COSTS, default_weights
    from llsrbm.planning.problem.placement import limits_of
    from llsrbm.robots import load_robot

    loaded = load_robot(robot)
    weights = default_weights() | loaded.file.planning
    rows = [
        ("weight", cost.name, f"{weights[cost.name]:g}", "", cost.unit, cost.effect)
        for cost in COSTS
        if cost.concerns(loaded)
    ]
    for limit, value in limits_of(loaded).values():
        scale, unit = (math.degrees(1), "deg") if limit.unit == "rad" else (1.0, limit.unit)
        values = (f"{scale * number:.4g}" for number in (limit.lowest, limit.highest))
        accepted = " to ".join(values)
        own = f"{scale * value:.4g}"
        rows.append(("limit", limit.name, own, accepted, unit, limit.effect))
    heading = ("", "name", "value", "range", "unit", "what raising it does")
    print(*aligned([heading, *rows]), sep="\n")
    return console.DONE
