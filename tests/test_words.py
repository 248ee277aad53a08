"""Plain English for strangers: names, docstrings, hints, help texts, scripts and documents.

A sentence has its subject where it begins: not "Of", "And", "What" and the like.
"""

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
ODD_OPENING = re.compile(
    r"(?:^|(?<=[.!?] )|(?<=[.!?]\n))(?:Of|And|By (?:which|what|how)|From (?:which|what)|What|Who"
    r"|Whoever|Whose)\b(?![^.!?]*\?)"
)
SHOWN = {"help", "hint", "label", "title", "description", "summary", "note", "text", "tooltip"}
FOLDERS = ("llsrbm", "app", "benchmarks")
COMMENT = re.compile(r"^\s*(?://|\*|/\*+)\s?(.*?)(?:\*/)?$")
FENCE = re.compile(r"^(```|~~~).*?^\1", re.MULTILINE | re.DOTALL)


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


def _shown(tree):
    """Texts for people: arguments and attributes with such names, and hints of tables of fields."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            named = [each.value for each in node.keywords if each.arg in SHOWN]
            for value in (*named, *node.args[:3]):
                if text := _text(value):
                    yield value.lineno, text
        elif isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            named = any(getattr(target, "id", "").lower() in SHOWN for target in targets)
            if named and (text := _text(node.value)):
                yield node.lineno, text


def _text(node):
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(part.value for part in node.values if isinstance(part, ast.Constant))
    return ""


def _paragraphs(lines):
    """Runs of lines that are text: number of the first, and the text."""
    start, held = 0, []
    for number, line in enumerate([*lines, ""], start=1):
        if line.strip() and not re.match(r"\s*(?:[-*#|>]|\d+\.) ?", line):
            held.append(line.strip())
            start = start or number
            continue
        if held:
            yield start, "\n".join(held)
        start, held = 0, []
        if item := re.match(r"\s*(?:[-*>]|\d+\.) +(.*)", line):
            start, held = number, [item[1]]


def _comments(source):
    lines = (COMMENT.match(line) for line in source.splitlines())
    return _paragraphs([line[1] if line else "" for line in lines])


def _odd(place, texts):
    for line, text in texts:
        for found in ODD_OPENING.finditer(text):
            end = text.find("\n", found.start())
            yield f"{place}:{line} begins with {text[found.start() : end if end > 0 else None]:.60}"


@pytest.mark.parametrize("folder", FOLDERS)
def test_names_docstrings_and_texts_are_plain_english(folder):
    found = []
    for path in sorted((ROOT / folder).rglob("*.py")):
        tree, place = ast.parse(path.read_text(encoding="utf-8")), path.relative_to(ROOT)
        for line, name in _names(tree):
            if PRIVATE_ENGLISH.search(name) or name in STRANGE_CLASSES:
                found.append(f"{place}:{line} is called {name}")
        found += _odd(place, _docstrings(tree))
        found += _odd(place, _shown(tree))
    assert not found, "\n".join(found)


def test_scripts_and_documents_are_plain_english():
    found = []
    for path in sorted((ROOT / "app").rglob("*.js")):
        found += _odd(path.relative_to(ROOT), _comments(path.read_text(encoding="utf-8")))
    for path in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))):
        text = FENCE.sub(lambda match: "\n" * match[0].count("\n"), path.read_text("utf-8"))
        found += _odd(path.relative_to(ROOT), _paragraphs(text.splitlines()))
    assert not found, "\n".join(found)


def test_the_checker_finds_them():
    texts = 'f(help="Of what it has."); hint = "And so on."; g("x", "Who does it. By which it is.")'
    assert len([*_odd("x", _shown(ast.parse(texts)))]) == 4
    assert len([*_odd("x", _comments("// It is. What is not\n// said. And more."))]) == 2
    assert not [*_odd("x", [(1, "Offsets of androids. What is it?")])]
