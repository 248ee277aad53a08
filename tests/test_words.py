"""Plain English for strangers: names and docstrings of the library, the page and the benchmarks."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PRIVATE_ENGLISH = re.compile(
    r"(?:^|_)(?:tell|tells|told|say|says|said|ask|asks|asked|feel|feels|felt|complain|complains)(?:_|$)"
)
STRANGE_CLASSES = {
    *("Course", "Demand", "Grip", "Known", "Lane", "Patience", "Scout", "Sight", "Strand", "Word"),
}
ODD_OPENING = re.compile(r"(?:What|Who|Whoever|Whose)\b")
FOLDERS = ("llsrbm", "app", "benchmarks")


def _names(tree):
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield node.lineno, node.name
        elif isinstance(node, ast.arg):
            yield node.lineno, node.arg
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.lineno, node.id


def _docstrings(tree):
    for node in ast.walk(tree):
        if isinstance(
            node, ast.Module | ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef
        ) and (text := ast.get_docstring(node)):
            yield getattr(node, "lineno", 1), text


@pytest.mark.parametrize("folder", FOLDERS)
def test_names_and_docstrings_are_plain_english(folder):
    found = []
    for path in sorted((ROOT / folder).rglob("*.py")):
        tree, place = ast.parse(path.read_text(encoding="utf-8")), path.relative_to(ROOT)
        for line, name in _names(tree):
            if PRIVATE_ENGLISH.search(name) or name in STRANGE_CLASSES:
                found.append(f"{place}:{line} is called {name}")
        for line, text in _docstrings(tree):
            if ODD_OPENING.match(text):
                found.append(f"{place}:{line} begins with {text.split()[0]}")
    assert not found, "\n".join(found)
