"""Every command of the pages is one that there is, with options that it takes.

A figure stands beside the command that makes it, so a figure whose command has gone fails here.
Nothing is run, but for the commands that list names.
"""

import re
import tomllib

import pytest
import typer

from llsrbm import models
from llsrbm.cli import main
from llsrbm.commands.program import app
from llsrbm.formats import FORMATS
from llsrbm.planning.problem.costs import default_weights
from llsrbm.planning.problem.limits import limit_unit
from llsrbm.request import jump_types
from llsrbm.request.design import find_design
from llsrbm.request.feet_order import is_order
from llsrbm.robots import names as robot_names
from tests.docs.benchmark_commands import check_benchmark, parse
from tests.docs.pages import PAGES, ROOT, blocks, commands

ALL = [command for page in PAGES for command in commands(page)]
LISTING = ("robots", "models", "types", "formats", "designs", "tuning")
PLACEHOLDER = re.compile(r"[A-Z]+|.*\.(toml|json|npz)")  # FILE, NAME, or a file of the reader's
COMMAND = r"(?m)(`|^ {4})(python|make|llsrbm) [^`\n]+"
INCOMPLETE = ("MissingParameter", "BadOptionUsage")  # as a command within a sentence may be


def of(program):
    """Parameters for a test: the different commands of a program."""
    different = {(command.words, command.whole): command for command in ALL}
    chosen = [command for command in different.values() if command.words[0] == program]
    return pytest.mark.parametrize("command", chosen, ids=str)


@of("llsrbm")
def test_commands_parse(command):
    words = [word for word in command.words[1:] if word != "..."]
    try:
        context = parse(typer.main.get_command(app), words)
    except typer.TyperException as error:
        if not command.whole and type(error).__name__ in INCOMPLETE:
            return
        raise
    given = context.params
    _check_names(given.get("robot"), robot_names())
    _check_names(given.get("model"), models.MODELS)
    types = _listed(given.get("type"))
    _check_names([name for name in types if not is_order(name)], jump_types.names())
    for order in filter(is_order, types):
        jump_types.load_type(order)
    dataset = context.command.name == "dataset"  # its limit is a number of motions
    _check_names(given.get("format_"), [*FORMATS, *(["lerobot"] if dataset else [])])
    if given.get("design") and not PLACEHOLDER.fullmatch(given["design"]):
        find_design(given["design"])
    for limit in _listed(None if dataset else given.get("limit")):
        assert limit_unit(limit.partition("=")[0]) is not None, limit
    for weight in _listed(given.get("weight")):
        assert weight.partition("=")[0] in default_weights(), weight


def _check_names(given, known):
    for name in _listed(given):
        assert name in known or PLACEHOLDER.fullmatch(name), (name, list(known))


def _listed(given):
    """A parameter that is there once, several times or not."""
    return [given] if isinstance(given, str) else given or []


@of("python")
def test_benchmarks_take_their_options(command):
    program, *words = command.words[1:]
    if program == "-m":
        program, *words = words
        assert program.startswith("benchmarks."), program
    name = program.removeprefix("benchmarks").strip("./").removesuffix(".py")
    places = (f"{name}.py", f"{name}/__main__.py")
    assert any((ROOT / "benchmarks" / place).is_file() for place in places), name
    check_benchmark(name, [word for word in words if word != "..."])


@of("make")
def test_targets_exist(command):
    makefile = (ROOT / "Makefile").read_text("utf-8")
    for word in command.words[1:]:
        variable, assigned, _ = word.partition("=")
        if assigned:
            assert re.search(rf"\$\({variable}\)|^{variable}\s*[:?]?=", makefile, re.MULTILINE)
        else:
            assert re.search(rf"^{word}:", makefile, re.MULTILINE), word


@of("pip")
def test_extras_exist(command):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    for extra in re.findall(r"llsrbm\[(\w+)\]", " ".join(command.words)):
        assert extra in project["optional-dependencies"]


def test_commands_were_found():
    """A pattern that finds nothing would make every test above pass."""
    programs = [command.words[0] for command in ALL]
    assert programs.count("llsrbm") > 80
    assert programs.count("python") > 20
    assert programs.count("make") > 5
    assert programs.count("pip") > 2


@pytest.mark.parametrize("name", LISTING)
def test_lists_are_printed(name, capsys):
    told = {command.words[1:] for command in ALL if command.words[:2] == ("llsrbm", name)}
    assert told
    for words in told:
        if not any(map(str.isupper, words)):
            assert main(words) == 0
            assert capsys.readouterr().out.strip()


class TestFigures:
    """Every figure has its command beside it."""

    def test_of_the_readme(self):
        text = (ROOT / "README.md").read_text("utf-8")
        head, rows = "| further figures | | made by |\n|---|---|---|\n", []
        rows = text.partition(head)[2].partition("\n\n")[0].splitlines()
        assert len(rows) > 3
        assert [row for row in rows if not re.search(r"\| `python [^`]+` \|$", row)] == []

    def test_of_their_page(self):
        """Every section with a number has a command, or a link to the page that has it."""
        assert _sections_without("figures.md", r"\d", rf"{COMMAND}|\]\([\w-]+\.md#") == []

    @pytest.mark.parametrize("name", ["jump_types.md", "maths.md", "replanning.md"])
    def test_of_tables_elsewhere(self, name):
        assert _sections_without(name, r"(?m)^\|[^a-z\n]*\d", COMMAND) == []


def _sections_without(name, figure, command):
    """Titles of a page's sections that have figures, but no command for them."""
    text = (ROOT / "docs" / name).read_text("utf-8")
    sections = [part.partition("\n") for part in re.split(r"(?m)^##+ (?=.)", text)[1:]]
    return [
        title
        for title, _, body in sections
        if re.search(figure, body) and not re.search(command, body)
    ]


def test_notes_are_known():
    """A misspelt comment would leave a block unrun."""
    for page in PAGES:
        for block in blocks(page):
            assert block.note in ("", "run") or block.note.startswith("not run: "), block
