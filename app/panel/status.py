"""The status line, one of the contract's words and what follows it; and the result of a seed."""

from dataclasses import dataclass
from enum import StrEnum
from html import escape

from llsrbm.number_text import decimal

_GREY, _GREEN, _RED, _AMBER = "#8a94a0", "#2f9e62", "#d6336c", "#d08a1d"


class Verdict(StrEnum):
    """A status line's first word."""

    PLANNING = "Planning"
    DRAFT = "Draft"
    FEASIBLE = "Feasible"
    NEAREST = "Nearest"
    INFEASIBLE = "Infeasible"
    SIMULATING = "Simulating"
    LANDED = "Landed"
    FELL = "Fell"
    FAILED = "Failed"
    CANCELLED = "Cancelled"


_COLOURS = {
    Verdict.PLANNING: _AMBER,
    Verdict.DRAFT: _AMBER,
    Verdict.FEASIBLE: _GREEN,
    Verdict.NEAREST: _AMBER,
    Verdict.INFEASIBLE: _RED,
    Verdict.SIMULATING: _AMBER,
    Verdict.LANDED: _GREEN,
    Verdict.FELL: _RED,
    Verdict.FAILED: _RED,
    Verdict.CANCELLED: _AMBER,
}


_OF_A_MOTION = (Verdict.DRAFT, Verdict.FEASIBLE, Verdict.NEAREST, Verdict.LANDED, Verdict.FELL)
"""Verdicts on a motion that can be checked; pressed, they open its certificate."""


MEANINGS = {
    "checks": "Checks that hold, of the whole body at 1 kHz: stops, drives, friction, slip, room "
    "and dynamics. The verdict's word shows them.",
    "Yaw inertia Izz, flight": "Izz is the moment of inertia about the vertical through the centre "
    "of mass; this is its mean in flight, against standing. Feet that are drawn in make it "
    "smaller, and the robot turns faster.",
    "Flight time": "Time without any foot on the ground",
    "Planned torque": "Largest share of the torque that a drive has at its speed, in the plan",
    "Peak torque": "Largest share of a drive's torque limit, in the simulation",
    "Model's turn error": "The turn of the whole body in flight beyond the plan, for what the "
    "model leaves out",
    "Turn": "The turn of the body about the axis of the flip or roll",
    "Yaw error": "The simulated base's yaw at its first contact against the plan's",
    "not strict": "Strict: it stands at the end, every foot within 50 mm of its place, tilt below "
    "2° then and below 15° before, and less than 30 ms of a second flight",
    "Tilt": "The base's tilt at the end against the landing surface",
    "Foot error": "Largest horizontal distance of a foot from its planned place at the end",
}


@dataclass(frozen=True)
class Checks:
    """How many checks of a certificate hold."""

    held: int
    of: int

    @property
    def html(self) -> str:
        """A badge."""
        kind = "held" if self.held == self.of else "broken"
        words = f"{self.held}/{self.of} checks"
        return f' <span class="llsrbm-checks {kind}"{_tip("checks")}>{words}</span>'


@dataclass(frozen=True)
class Status:
    """Progress or outcome of what is computed: a large word, and what a roboticist asks next."""

    verdict: Verdict  # with which it begins
    rest: str = ""  # a sentence that follows the word
    busy: bool = False  # whether there is something to cancel, and all this may change
    share: float | None = None  # of it that is done, 0 to 1; None where that is not known
    limit: str = ""  # of the verdict, large as it is: "not strict"
    figures: tuple[tuple[str, str], ...] = ()  # titles and values
    points: tuple[str, ...] = ()  # short sentences before the figures
    outdated: bool = False  # it is of another scenario
    checks: Checks | None = None  # of the motion's certificate; None: it has none
    old: bool = False  # the figures are of the motion before the one that is computed
    lasts: float | None = None  # s, about, what is computed; None where that is not known

    @property
    def html(self) -> str:
        """All of it, as high as it has to be (static/panel.js)."""
        kind = " outdated" if self.outdated else ""
        figures = "".join(
            f"<div{_tip(title)}><dt>{escape(title)}</dt> <dd>{escape(value)}</dd></div> "
            for title, value in self.figures
        )
        points = "".join(f"<li>{escape(point)}</li> " for point in self.points)
        rest = f" <span>{escape(self.rest)}</span>" if self.rest else ""
        old = ' class="old" aria-label="Of the motion before"' if self.old else ""
        return (
            f'<div class="llsrbm-status{kind}" style="--verdict:{self._colour}">'
            f'<div role="status" aria-busy="{str(self.busy).lower()}">'
            f"<b>{self._word}</b>{'' if self.checks is None else self.checks.html}{rest}"
            f"{f' <ul>{points}</ul>' if points else ''}"
            f"{f' <dl{old}>{figures}</dl>' if figures else ''}"
            f"</div>{_bar(self.share, self.lasts, busy=self.busy)}</div>"
        )

    @property
    def _colour(self) -> str:
        if self.outdated:
            return _GREY
        return _AMBER if self.busy else _COLOURS[self.verdict]

    @property
    def _word(self) -> str:
        word = self.verdict.value
        large = escape(f"{word}, {self.limit}" if self.limit else word)
        if self.verdict in _OF_A_MOTION and not self.busy:
            tip = f"{MEANINGS[self.limit]}. " if self.limit in MEANINGS else ""
            return (
                f'<button type="button" data-tip="{escape(tip)}Press to see the checks">{large}'
                "</button>"
            )
        return large


@dataclass(frozen=True)
class SeedResult:
    """Outcome of the simulation of one seed."""

    seed: int  # of its disturbance
    landed: bool  # whether the robot stands at the end
    strict: bool  # whether it landed by the strict measure (`llsrbm.simulation.verdict`)
    fell_at_s: float | None  # when it fell; None if it landed
    foot_error: float  # largest horizontal distance of a foot from the plan's at the end, m
    line: str  # the same in words


def _tip(title: str) -> str:
    """The attribute by which the page says what a figure means (static/tips.js)."""
    return f' data-tip="{escape(MEANINGS[title])}"' if title in MEANINGS else ""


def _bar(share: float | None, lasts: float | None, *, busy: bool) -> str:
    """A bar: how much is done, or will be by now, or that something is; else its place."""
    if share is None and lasts is not None and busy:
        return (
            '<div class="llsrbm-progress" role="progressbar" aria-label="Progress">'
            f'<div class="lasts" style="animation-duration:{lasts:g}s"></div></div>'
        )
    if share is None:
        return f'<div class="llsrbm-progress{" unknown" if busy else ""}"></div>'
    done = decimal(100 * min(max(share, 0.0), 1.0))
    return (
        '<div class="llsrbm-progress" role="progressbar" aria-label="Progress" aria-valuemin="0" '
        f'aria-valuemax="100" aria-valuenow="{done}"><div style="width:{done}%"></div></div>'
    )
