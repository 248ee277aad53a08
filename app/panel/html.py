"""The panel's pieces of HTML: status, tables, legend. Everything shown is escaped."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

from app.motion import colours
from app.motion.colours import Rgb
from app.motion.push_arrow import ARROW_PER_SPEED
from app.panel.status import Status, Word
from app.picture.overlays.centre_of_mass import CentreOfMass
from app.picture.overlays.forces import ARROW_PER_WEIGHT, Forces
from app.picture.overlays.ghosts import Ghosts
from app.picture.overlays.inertia_ellipsoids import InertiaEllipsoids
from app.picture.overlays.landing_marks import LandingMarks
from app.picture.overlays.landing_region import LandingRegion
from app.picture.overlays.new_plans import NewPlans
from app.picture.overlays.pushes import Pushes
from app.picture.overlays.trails import Trails
from llsrbm.request.messages import decimal

PADDING = "padding:0.35em 0.9em"
SMALL = f"{PADDING};font-size:0.8em;line-height:1.5"
DIM = "color:var(--mantine-color-dimmed)"
_NAME = (
    "text-align:left;font-weight:normal;padding-right:0.8em;vertical-align:top;white-space:nowrap"
)
_STATUS_LINES = 3  # that are always there: what stands below must not jump

_STATUS_COLOURS = {
    Word.PLANNING: "#8a94a0",
    Word.PLANNED: "#2f9e62",
    Word.SIMULATING: "#8a94a0",
    Word.LANDED: "#2f9e62",
    Word.FELL: "#d6336c",
    Word.FAILED: "#d6336c",
    Word.CANCELLED: "#d08a1d",
}


def status(status: Status) -> str:
    """One line that begins with one of the contract's words."""
    colour = _STATUS_COLOURS[status.word]
    return (
        f'<div class="llsrbm-status"><div role="status" style="{PADDING};font-size:0.8em;'
        f"line-height:1.35;min-height:{_STATUS_LINES * 1.35}em;box-sizing:content-box;"
        f'border-left:4px solid {colour};margin:0.3em 0"><b>{escape(status.word.value)}</b>'
        f"{_joint(status.rest)}{escape(status.rest)}</div>{_progress(status.share)}</div>"
    )


def _joint(rest: str) -> str:
    """The words between the status word and the rest: "Landed, but ..."."""
    return "" if rest.startswith((",", ".")) else " "


def _progress(share: float | None) -> str:
    """A bar that takes the same place when there is none."""
    if share is None:
        return '<div class="llsrbm-progress"></div>'
    done = decimal(100 * min(max(share, 0.0), 1.0))
    return (
        '<div class="llsrbm-progress" role="progressbar" aria-label="Progress" aria-valuemin="0" '
        f'aria-valuemax="100" aria-valuenow="{done}"><div style="width:{done}%"></div></div>'
    )


def note(text: str) -> str:
    """A sentence on what is there, or what to do."""
    return f'<div style="{SMALL};{DIM}">{escape(text)}</div>'


TOUR_BUTTON = (
    f'<div style="{SMALL}"><button type="button" data-tour '
    'style="font:inherit;color:inherit;padding:0.3em 0.9em;border-radius:4px;cursor:pointer;'
    "background:var(--mantine-color-default);"
    'border:1px solid var(--mantine-color-default-border)">Start the tour</button></div>'
)
"""Begins the tour of the page; handled in the page alone (static/tour.js)."""


def table(rows: Iterable[tuple[str, str]], title: str = "") -> str:
    """Names and values."""
    body = "".join(
        f'<tr><th scope="row" style="{_NAME};{DIM}">{escape(name)}</th>'
        f'<td style="font-variant-numeric:tabular-nums">{escape(value)}</td></tr>'
        for name, value in rows
    )
    head = f"<b>{escape(title)}</b>" if title else ""
    compact = "border-spacing:0;font-size:0.96em;letter-spacing:-0.3px"
    return f'<div style="{SMALL}">{head}<table style="{compact}">{body}</table></div>'


def legend(
    layers: frozenset[str], *, simulated: bool, pushed: bool = False, replans: bool = False
) -> str:
    """The colours of what is drawn.

    Args:
        layers: names of the overlays that are drawn.
        simulated: whether there is a simulation.
        pushed: whether the robot is pushed in it; replans: whether it plans anew.
    """
    rows: list[tuple[Rgb, str]] = []
    if InertiaEllipsoids.name in layers:
        rows += [
            (colours.PLANNED, "ellipsoid: uniform solid of the robot's mass and planned inertia"),
            (colours.SIMULATED, "the same of the simulated whole body's inertia")
            if simulated
            else (colours.RIGID, "the same of SRBM's inertia, which is constant"),
        ]
    if simulated and Ghosts.name in layers:
        rows.append((colours.PLANNED, "the plan, a ghost beside the simulated robot"))
    if Forces.name in layers:
        kind = "measured" if simulated else "planned"
        rows.append(
            (
                colours.FORCE,
                f"contact forces, {kind}; the weight is {ARROW_PER_WEIGHT:g}\u00a0m long",
            )
        )
    if pushed and Pushes.name in layers:
        length = f"{ARROW_PER_SPEED:g}\u00a0m"
        rows.append((colours.PUSH, f"push; one that gives the robot 1\u00a0m/s is {length} long"))
    if replans and NewPlans.name in layers:
        rows.append((colours.REPLANNED, "newest plan: path of the centre of mass, footholds"))
    if (pushed or replans) and LandingRegion.name in layers:
        rows.append((colours.REPLANNED, "outlines: where the feet can still land"))
    if CentreOfMass.name in layers or Trails.name in layers:
        rows.append((colours.COM, "centre of mass"))
    if LandingMarks.name in layers:
        rows.append((colours.TARGET, "landing place: drag it"))
    return f'<div class="llsrbm-wide">{_keys(rows)}</div>' if rows else ""


def _keys(rows: Iterable[tuple[Rgb, str]]) -> str:
    body = "".join(f"<div>{swatch(colour)}{escape(text)}</div>" for colour, text in rows)
    return f'<div style="{SMALL}">{body}</div>'


def swatch(colour: Rgb) -> str:
    """A small square of a colour, before what it stands for."""
    return (
        '<span style="display:inline-block;width:0.8em;height:0.8em;border-radius:0.2em;'
        f'background:{colours.css(colour)};margin-right:0.5em"></span>'
    )
