"""Options that commands share: what jump is wanted, where results go."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from llsrbm.jump import Jump

Robot = Annotated[str, typer.Option(help="A name (see `llsrbm robots`) or a robot file's path.")]
Model = Annotated[str, typer.Option(help="See `llsrbm models`.")]
Twist = Annotated[float, typer.Option(metavar="DEG", help="Turn to the left.")]
Forward = Annotated[float, typer.Option(metavar="M", help="Displacement along x.")]
Lateral = Annotated[float, typer.Option(metavar="M", help="Displacement to the left.")]
Height = Annotated[float, typer.Option(metavar="M", help="Of the landing surface.")]
Planner = Annotated[str, typer.Option(help="fatrop or ipopt.")]
Out = Annotated[Path | None, typer.Option(metavar="FILE", help="Write the result here (npz).")]
AsJson = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on stdout, the rest on stderr.")
]

# Names of the options that say what to plan, and how.
PLANNING = ("design", "robot", "model", "twist", "forward", "lateral", "height", "solver")


def is_given(context: typer.Context, name: str) -> bool:
    """Whether a parameter of a command stands on the command line."""
    source = context.get_parameter_source(name)
    return source is not None and source.name != "DEFAULT"


def requested_jump(
    robot: str, model: str, twist: float, forward: float, lateral: float, height: float
) -> Jump:
    """The request in the library's units, from the command line's: degrees and m."""
    return Jump(
        robot=robot,
        model=model,
        twist=math.radians(twist),
        forward=forward,
        lateral=lateral,
        height=height,
    )


def described(jump: Jump) -> str:
    """The request in one line, in the command line's units."""
    return (
        f"{jump.robot}, {jump.model}: twist {math.degrees(jump.twist):.0f} deg, forward "
        f"{jump.forward:.2f} m, lateral {jump.lateral:.2f} m, height {jump.height:.2f} m"
    )
