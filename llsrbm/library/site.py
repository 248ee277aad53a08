"""A library as a static site, which opens from disk: a list with filters, and a page a motion.

    DIR/index.html              all motions, with filters and moving stick figures
    DIR/motions/NAME.html       figures, player, certificate, downloads
    DIR/players/NAME.html       the replay alone, for frames; what replays share is in `shared`
    DIR/downloads/NAME.csv      base and joints at 25 Hz; NAME.jump.json: the request
    DIR/library/                the library's own files, with its card

Nothing is asked of a network, and nothing is simulated.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

from llsrbm.certificate import Certificate, stated
from llsrbm.errors import InputError
from llsrbm.files.atomic import MARK, staged
from llsrbm.formats import export, export_many
from llsrbm.installed import package_version
from llsrbm.library.card import Card
from llsrbm.library.description import write_description
from llsrbm.library.file import as_text
from llsrbm.library.library import Library
from llsrbm.library.stick_figure import StickFigure
from llsrbm.look.titles import title, title_of_robot
from llsrbm.motion.plan import Plan
from llsrbm.motion.trajectory import Trajectory
from llsrbm.number_text import decimal, degrees, percent

RATE = 25.0  # frames/s of players and tables: a player mixes between them
_OWN = ("site.css", "stick_figure.js", "site.js")
_DOWNLOADS = (
    ("unitree-csv", ".csv", "base and joints, a row a frame"),
    ("design", ".jump.json", "the request, which the designer opens"),
)


def write_site(
    library: Library, folder: Path, progress: Callable[[int, int], None] = lambda *_: None
) -> None:
    """Write a library's site into a new folder, or in place of one that this wrote.

    Raises `InputError`: the library is empty, pages that play are not installed, or the folder
    cannot be written, or has other things in it.
    """
    cards = sorted(library.cards, key=lambda card: card.name)
    if not cards:
        raise InputError(f"{library.folder}: there are no motions; expected some to show")
    with staged(folder) as draft:
        for name in ("motions", "downloads"):
            (draft / name).mkdir(parents=True)
        rows, figures = list[dict[str, Any]](), library.stick_figures()

        def opened() -> Iterator[tuple[str, Trajectory]]:
            for number, card in enumerate(cards):
                plan = library.open(card.name, check=False)
                _write_motion(draft, card, plan)
                rows.append(_row(card, figures.get(card.name)))
                yield card.name, plan
                progress(number + 1, len(cards))

        export_many(opened(), draft / "players", "html", fps=RATE)
        _copy_library(library, draft / "library")
        (draft / "index.html").write_text(_index(rows), encoding="utf-8")
        for name in _OWN:
            text = (files("llsrbm.library") / name).read_text("utf-8")
            (draft / name).write_text(text, encoding="utf-8")
        mark = {"package_version": package_version(), "motions": len(cards)}
        (draft / MARK).write_text(as_text(mark), encoding="utf-8")


def _copy_library(library: Library, folder: Path) -> None:
    folder.mkdir()
    for path in library.files:
        shutil.copyfile(path, folder / path.name)
    write_description(Library(folder))


def _row(card: Card, figure: StickFigure | None) -> dict[str, Any]:
    """A motion for the list (site.js)."""
    figures, done = card.figures, card.simulated
    return {
        "name": card.name,
        "robot": title_of_robot(card.robot),
        "kind": card.kind,
        "distance": round(figures.distance_m, 3),
        "turn": round(figures.turn, 3),
        "height": round(figures.height_m, 3),
        "flight": round(figures.flight_s, 3),
        "power": round(figures.peak_power_w),
        "torque": round(figures.torque_share, 3),
        "strict": [done.strict, done.seeds],
        "figure": None if figure is None else figure.drawn(figures.duration_s),
    }


def _index(rows: list[dict[str, Any]]) -> str:
    data = json.dumps(rows, separators=(",", ":")).replace("<", "\\u003c")
    robots = sorted({row["robot"] for row in rows})
    intro = (
        f"<p>{len(rows)} motions of {len(robots)} robots. Each is a plan of the whole body whose "
        "certificate holds at 1 kHz. Strict: simulations with everything disturbed that landed "
        "within 50 mm and 2° without anything but feet touching.</p>"
    )
    body = (
        f"<h1>Library of motions</h1>{intro}"
        '<form id="filters" aria-label="Filters"></form><p id="count" role="status"></p>'
        '<div id="motions"></div>'
        '<p>All files: <a href="library/README.md">library</a>, with its '
        '<a href="library/card.json">card</a> (counts, ranges, checks, checksums).</p>'
        f'<script type="application/json" id="rows">{data}</script>'
        '<script src="stick_figure.js"></script><script src="site.js"></script>'
    )
    return _page("Library of motions", body, "")


def _page(name: str, body: str, up: str) -> str:
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<title>{escape(name)}</title><link rel="stylesheet" href="{up}site.css"></head>'
        f"<body><main>{body}</main></body></html>\n"
    )


def _write_motion(folder: Path, card: Card, plan: Plan) -> None:
    for format_, suffix, _ in _DOWNLOADS:
        taken = {"fps": RATE} if format_ != "design" else {}
        export(plan, folder / "downloads" / f"{card.name}{suffix}", format=format_, **taken)
    certificate = stated(plan)
    assert certificate is not None  # a motion's card has one
    links = "".join(
        f'<li><a href="../downloads/{card.name}{suffix}" download>{card.name}{suffix}</a>: '
        f"{words}</li>"
        for _, suffix, words in _DOWNLOADS
    )
    body = (
        f'<p><a href="../index.html">All motions</a></p><h1>{escape(title(plan))}</h1>'
        f"<p><code>{card.name}</code></p>"
        f'<iframe src="../players/{card.name}.html" title="Player"></iframe>'
        f"<h2>Figures</h2>{_table(_figures(card))}"
        f"<h2>Certificate</h2>{_certificate(certificate)}"
        f"<h2>Files</h2><ul>{links}</ul>"
        "<p>In any other format, torques and feedback gains among them:</p>"
        f"<pre>llsrbm library export {card.name} --format motion-npz --out {card.name}.npz\n"
        f"llsrbm library export {card.name} --format mujoco --out {card.name}</pre>"
    )
    text = _page(card.name, body, "../")
    (folder / "motions" / f"{card.name}.html").write_text(text, encoding="utf-8")


def _figures(card: Card) -> list[tuple[str, ...]]:
    figures, done = card.figures, card.simulated
    return [
        ("forward, left, up", _lengths(figures.forward_m, figures.lateral_m, figures.height_m)),
        ("turn to the left", degrees(figures.turn, 0)),
        ("in the air", f"{decimal(figures.flight_s, 2)} of {decimal(figures.duration_s, 2)} s"),
        ("rise of the CoM", f"{decimal(figures.apex_m, 2)} m"),
        ("peak power of the drives", f"{decimal(figures.peak_power_w)} W"),
        ("largest share of a drive's torque at its speed", percent(figures.torque_share)),
        ("strict in simulation, everything disturbed", f"{done.strict} of {done.seeds}"),
    ]


def _lengths(*values: float) -> str:
    return ", ".join(f"{decimal(value, 2)} m" for value in values)


def _certificate(certificate: Certificate) -> str:
    head = ("check", "", "worst", "allowed", "where", "when")
    rows: list[tuple[str, ...]] = [head]
    for found in certificate:
        words = "holds" if found.holds else "does not hold"
        if found.worst is None or found.allowed is None:
            rows.append((found.name, words, "", "", found.why, ""))
        else:
            worst, allowed = found.shown(found.worst), found.shown(found.allowed)
            rows.append((found.name, words, worst, allowed, found.where, found.when))
    return _table(rows, headed=True)


def _table(rows: list[tuple[str, ...]], *, headed: bool = False) -> str:
    parts = []
    for number, row in enumerate(rows):
        cell = "th" if headed and number == 0 else "td"
        parts.append(f"<tr>{''.join(f'<{cell}>{escape(text)}</{cell}>' for text in row)}</tr>")
    return f"<table>{''.join(parts)}</table>"
