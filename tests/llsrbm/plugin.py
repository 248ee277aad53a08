"""A command as another package would register it."""

from typing import Annotated

import typer

from llsrbm.errors import InputError


def greet(
    name: Annotated[str, typer.Option(help="Whom.")] = "world",
    times: Annotated[int, typer.Option()] = 1,
) -> None:
    """Say hello."""
    if name == "nobody":
        raise InputError("nobody is not somebody")
    for _ in range(times):
        print(f"hello {name}")
