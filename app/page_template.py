"""The page as it is served: viser's, with a title of its own and our scripts before all others."""

import gzip
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path

import viser

import llsrbm
from app.guard.limits import MAX_UPLOAD
from llsrbm.errors import Error

SCRIPTS = (
    "address.js",
    "graphics.js",
    "elements.js",
    "layout.js",
    "page.js",
    "dialog.js",
    "player.js",
    "timeline.js",
    "transport.js",
    "shaping.js",
    "camera.js",
    "remark.js",
    "legend.js",
    "pins.js",
    "compare.js",
    "parts.js",
    "handles.js",
    "stick_figure.js",
    "gallery.js",
    "exports.js",
    "help.js",
    "tour.js",
    "panel.js",
    "tuning.js",
    "atlas.js",
    "certificate.js",
    "tint.js",
    "plot_figure.js",
    "sheet.js",
    "plots.js",
    "accessibility.js",
    "tips.js",
    "numbers.js",
    "file_drop.js",
)
"""In the order in which they need each other; the library's own are shared with its site."""

HEAD = f"""<title>Jump designer</title>
<meta name="largest-file" content="{MAX_UPLOAD}">
"""
"""In place of viser's title, before the scripts."""

_TITLE = "<title>Viser</title>"
_FOLDERS = Path(__file__).parent / "static", Path(llsrbm.__file__).parent / "library"


@lru_cache(maxsize=1)
def page_html() -> bytes:
    """Read once; raises `Error` where viser's page has no place for our scripts."""
    page = (Path(viser.__file__).parent / "client" / "build" / "index.html").read_text("utf-8")
    if _TITLE not in page:
        raise Error(f"the page of viser {viser.__version__} has no place for our scripts")
    return page.replace(_TITLE, HEAD + embedded(SCRIPTS), 1).encode("utf-8")


def embedded(scripts: Iterable[str]) -> str:
    """Our scripts of these names, as elements of a page."""
    return "".join(
        f"<script>\n{script_file(name).read_text('utf-8')}</script>\n" for name in scripts
    )


def script_file(name: str) -> Path:
    """Where one of our scripts lies: in `static`, or in the library's package."""
    return next(folder / name for folder in _FOLDERS if (folder / name).is_file())


@lru_cache(maxsize=1)
def page_gzip() -> bytes:
    """The same, compressed once."""
    return gzip.compress(page_html(), 6)


def page(gzipped: bool) -> bytes:
    """As the browser takes it."""
    return page_gzip() if gzipped else page_html()
