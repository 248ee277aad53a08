"""`--design` of the commands that plan or simulate, and `llsrbm designs`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

import typer

from llsrbm.commands import console
from llsrbm.commands.field_options import requested_jump

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


def designs_command() -> int:
    """List the designs that come with the project."""
    from llsrbm.request.design import examples

    listed = examples()
    width = max(len(name) for name in listed)
    for name, design in listed.items():
        print(f"{name:{width}}  {design.title}")
    return console.DONE


def requested_design(name_or_path: str | None, requested: Mapping[str, Any]) -> Design:
    """The design that was named, its jump as the options of a command line change it.

    Args:
        name_or_path: as `llsrbm.request.design.find_design` takes it; None: only the jump.
        requested: as `llsrbm.commands.field_options.requested_jump` takes it.
    """
    from llsrbm.request.design import Design, find_design

    if name_or_path is None:
        return Design(requested_jump(requested))
    design = find_design(name_or_path)
    return replace(design, jump=requested_jump(requested, design.jump))
