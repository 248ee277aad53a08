"""Links of the pages to files outside of `docs/`, which the site does not hold.

In the repository `[planning](../llsrbm/planning)` is a link to the code. The site has no copy of
the code, and the repository has no public address, so there the link becomes its path. A path that
does not exist is a warning, on which the strict build fails.
"""

from __future__ import annotations

import logging
import posixpath
import re
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
LOG = logging.getLogger("mkdocs.hooks.source_links")
LINK = re.compile(r"(?<!!)\[([^\]\[]+)\]\(([^)\s]+)\)")


def on_page_markdown(markdown: str, *, page: Any, **_: Any) -> str:
    """The page with its links to code as paths."""
    return paths_of_links(markdown, page.file.src_uri)


def paths_of_links(markdown: str, source: str) -> str:
    """The text with links to files outside of `docs/` replaced.

    Args:
        markdown: a page's text.
        source: the page's place in `docs/`.
    """

    def replaced(link: re.Match[str]) -> str:
        text, target = link.groups()
        if "://" in target or target.startswith(("#", "mailto:")):
            return link.group()
        path = posixpath.normpath(
            posixpath.join("docs", posixpath.dirname(source), target.partition("#")[0])
        )
        outside = not path.startswith("docs/") or path.startswith("docs/hooks/")
        if not outside:
            return link.group()
        if not (ROOT / path).exists():
            LOG.warning("%s: %s: no such file", source, target)
            return link.group()
        plain = text.strip("`")
        return text if plain == path else f"{text} (`{path}`)"

    return LINK.sub(replaced, markdown)
