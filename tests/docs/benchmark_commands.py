"""Whether a benchmark takes some options, found without running it.

With argparse `main` is called with a parser that stops once it has parsed; with typer the command
is made as `typer.run` makes it, and parses alone.
"""

import argparse
import sys
from functools import cache
from importlib import import_module
from unittest.mock import patch

import pytest
import typer
from typer.core import TyperGroup


class _Parsed(Exception):
    """The parser has taken all that was given."""


def check_benchmark(name: str, words: list[str]) -> None:
    """Fail with one line if there is no such benchmark, or it refuses the words."""
    try:
        module = import_module(f"benchmarks.{name}")
        if hasattr(module, "__path__"):  # a folder of scripts
            module = import_module(f"benchmarks.{name}.__main__")
    except ModuleNotFoundError as error:
        pytest.fail(str(error))
    if hasattr(module, "argparse"):
        _check_argparse(module, words)
    elif hasattr(module, "typer"):
        parse(_typer_command(module), words)
    else:
        options = [word for word in words if word.startswith("-")]
        assert not options, f"benchmarks.{name} takes no options"


def parse(command, words: list[str], context=None):
    """The context of the innermost command, its parameters parsed; nothing is run.

    Raises:
        typer.TyperException: a parameter is wrong or missing.
    """
    context = context or command.context_class(command, info_name="program")
    words = list(words)
    while isinstance(command, TyperGroup) and words and not words[0].startswith("-"):
        name = words.pop(0)
        inner = command.get_command(context, name)
        if inner is None:
            raise typer.TyperException(f'no command "{name}"')
        command, context = inner, inner.context_class(inner, info_name=name, parent=context)
    return command.make_context(command.name, words, parent=context.parent)


def _check_argparse(module, words):
    own = argparse.ArgumentParser.parse_args

    def parse_args(parser, *arguments, **options):
        own(parser, *arguments, **options)
        raise _Parsed

    with (
        patch.object(argparse.ArgumentParser, "parse_args", parse_args),
        patch.object(sys, "argv", [module.__name__, *words]),
        pytest.raises(_Parsed),
    ):
        module.main()


@cache
def _typer_command(module):
    app = getattr(module, "app", None)
    if not isinstance(app, typer.Typer):
        app = typer.Typer()
        app.command()(module.main)
    return typer.main.get_command(app)
