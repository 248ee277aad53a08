"""Formulas as MathML, which browsers draw by themselves: no script, and nothing from a network.

`pymdownx.arithmatex` marks the formulas of a page; here each is converted as the page is built.
"""

from __future__ import annotations

import html
import re
from typing import Any

from latex2mathml.converter import convert

MARKED = re.compile(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', re.DOTALL)


def on_page_content(content: str, **_: Any) -> str:
    """The page's HTML with its formulas converted."""
    return MARKED.sub(_mathml, content)


def _mathml(marked: re.Match[str]) -> str:
    tag, opening, formula = marked.groups()
    display = "block" if opening == "[" else "inline"
    converted = convert(html.unescape(formula).strip(), display=display)
    return f'<{tag} class="formula">{converted}</{tag}>'
