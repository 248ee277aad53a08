"""The documentation's pages, taken apart: headings, links, commands and code.

A comment directly before a block of code says what the tests do with it: `<!-- run -->` runs a
block of shell commands, `<!-- not run: reason -->` leaves a block of Python alone.
"""

import re
import shlex
from collections import Counter
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from markdown_it import MarkdownIt

ROOT = Path(__file__).parents[2]
PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
PROGRAMS = ("llsrbm", "python", "make", "pip", ".venv/bin/llsrbm")
_SEPARATORS = re.compile(r"[;&|]+")


class Link(NamedTuple):
    """Where a page leads, or the picture that it shows."""

    target: str
    line: int


class Block(NamedTuple):
    """A block of code; `note` is the comment before it."""

    language: str
    text: str
    line: int
    note: str


class Command(NamedTuple):
    """A command line of a page; `whole` if it stands in a block, not within a sentence."""

    words: tuple[str, ...]
    page: str
    line: int
    whole: bool

    def __str__(self) -> str:
        return f"{self.page}:{self.line} {' '.join(self.words)}"


def name_of(page: Path) -> str:
    """As messages and test names have it: docs/files.md."""
    return page.relative_to(ROOT).as_posix()


@cache
def tokens(page: Path):
    """The page as markdown-it reads it."""
    return MarkdownIt("commonmark").enable("table").parse(page.read_text("utf-8"))


def links(page: Path) -> list[Link]:
    """Links and pictures."""
    return [
        Link(target, line)
        for token, line in _inline(page)
        if (target := token.attrGet("src" if token.type == "image" else "href"))
    ]


def inline_code(page: Path) -> list[tuple[str, int]]:
    """What stands between single backticks, with its line."""
    return [(token.content, line) for token, line in _inline(page) if token.type == "code_inline"]


@cache
def anchors(page: Path) -> frozenset[str]:
    """Anchors of the headings, as code-hosting sites and the site's own slugs make them."""
    found: Counter[str] = Counter()
    made = set()
    parsed = tokens(page)
    for opening, text in pairwise(parsed):
        if opening.type != "heading_open":
            continue
        words = "".join(child.content for child in text.children)
        slug = re.sub(r"[^\w\- ]", "", words.strip().lower()).replace(" ", "-")
        made.add(f"{slug}-{found[slug]}" if found[slug] else slug)
        found[slug] += 1
    return frozenset(made)


def blocks(page: Path) -> list[Block]:
    """Fenced and indented code, in order."""
    found, note = [], ""
    for token in tokens(page):
        if token.type in ("fence", "code_block"):
            language = token.info.split()[0] if token.info.strip() else ""
            found.append(Block(language, token.content, token.map[0] + 1, note))
        comment = re.fullmatch(r"<!-- (.*?) -->\s*", token.content)
        note = comment.group(1) if token.type == "html_block" and comment else ""
    return found


def commands(page: Path) -> list[Command]:
    """Command lines of the project's programs, of blocks and of sentences."""
    found = [
        Command(words, name_of(page), block.line, True)
        for block in blocks(page)
        if block.language in ("", "sh", "bash")
        for words in command_lines(block.text)
    ]
    found += [
        Command(words, name_of(page), line, False)
        for text, line in inline_code(page)
        for words in command_lines(text)
    ]
    return found


def command_lines(text: str) -> Iterator[tuple[str, ...]]:
    """The words of each command in a piece of shell, of those that are the project's programs."""
    for line in text.replace("\\\n", " ").splitlines():
        if not line.strip().startswith(tuple(f"{program} " for program in PROGRAMS)):
            continue
        lexer = shlex.shlex(line, posix=True, punctuation_chars=";&|")
        lexer.whitespace_split = True
        words: list[str] = []
        for word in (*lexer, ";"):
            if not _SEPARATORS.fullmatch(word):
                words.append(word)
                continue
            if words and words[0] in PROGRAMS:
                yield (words[0].rpartition("/")[2], *words[1:])
            words = []


def _inline(page: Path):
    for token in tokens(page):
        for child in token.children or ():
            yield child, (token.map or [0])[0] + 1
