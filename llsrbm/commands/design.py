"""`--design` of the commands that plan or simulate, and `llsrbm designs`."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

import typer

from llsrbm.commands import console, options
from llsrbm.jump import Jump

if TYPE_CHECKING:
    from llsrbm.design import Design

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
    from llsrbm.examples import examples

    listed = examples()
    width = max(len(name) for name in listed)
    for name, design in listed.items():
        print(f"{name:{width}}  {design.title}")
    return console.DONE


def requested_design(context: typer.Context, name_or_path: str | None, jump: Jump) -> Design:
    """The design that was named, its jump as the options of this command line change it.

    Args:
        context: of the command, to know which options were given.
        name_or_path: as `llsrbm.examples.find_design` takes it; None: only the jump.
        jump: what the options say, defaults included.
    """
    from llsrbm.design import Design
    from llsrbm.examples import find_design

    if name_or_path is None:
        return Design(jump)
    design = find_design(name_or_path)
    given = {
        name: value for name, value in jump.as_dict().items() if options.is_given(context, name)
    }
    return replace(design, jump=replace(design.jump, **given))
