"""`llsrbm robots | models | formats | export`: what there is, and files in another format."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from llsrbm.commands import console


def export_command(
    file: Annotated[Path, typer.Argument(metavar="FILE.npz", help="A native file.")],
    out: Annotated[Path, typer.Option(metavar="FILE", help="The file to write.")],
    format_: Annotated[str, typer.Option("--format", metavar="F", help="See `llsrbm formats`.")],
    fps: Annotated[float, typer.Option(help="Frames per second, for formats with a rate.")] = 60.0,
) -> int:
    """Write a native file, a plan's or a rollout's, in another format."""
    from llsrbm.exporters import export
    from llsrbm.trajectory.files import load

    export(load(file), out, format=format_, fps=fps)
    return console.DONE


def robots_command() -> int:
    """List the robots that come with the project."""
    from llsrbm.robots import read_robot_file
    from llsrbm.robots.assets import robot_files

    _print_table({name: read_robot_file(path).title for name, path in robot_files().items()})
    return console.DONE


def models_command() -> int:
    """List the models that a planner can believe in."""
    from llsrbm import models

    _print_table(models.describe())
    return console.DONE


def formats_command() -> int:
    """List the formats that `llsrbm export` writes."""
    from llsrbm.exporters import formats

    _print_table(formats())
    return console.DONE


def _print_table(rows: dict[str, str]) -> None:
    width = max(len(name) for name in rows)
    for name, description in rows.items():
        print(f"{name:{width}}  {description}")
