"""The status line, one of the contract's words and what follows it; and the result of a seed."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from html import escape

from llsrbm.request.messages import decimal

_LINES = 3  # that are always there: what stands below must not jump
_GREY, _GREEN, _RED, _AMBER = "#8a94a0", "#2f9e62", "#d6336c", "#d08a1d"


class Verdict(StrEnum):
    """A status line's first word."""

    PLANNING = "Planning"
    PLANNED = "Planned"
    SIMULATING = "Simulating"
    LANDED = "Landed"
    FELL = "Fell"
    FAILED = "Failed"
    CANCELLED = "Cancelled"


_COLOURS = dict(zip(Verdict, (_GREY, _GREEN, _GREY, _GREEN, _RED, _RED, _AMBER), strict=True))


@dataclass(frozen=True)
class Status:
    """Progress or outcome of what is computed."""

    verdict: Verdict  # with which the line begins
    rest: str  # that follows it
    busy: bool = False  # whether there is something to cancel
    share: float | None = None  # of it that is done, 0 to 1; None where that is not known

    @property
    def html(self) -> str:
        """The line with its bar, to be shown in the panel."""
        word, colour = self.verdict.value, _COLOURS[self.verdict]
        joint = "" if self.rest.startswith((",", ".")) else " "  # "Landed, but ..."
        return (
            '<div class="llsrbm-status"><div role="status" style="padding:0.35em 0.9em;'
            f"font-size:0.8em;line-height:1.35;min-height:{_LINES * 1.35}em;"
            f'box-sizing:content-box;border-left:4px solid {colour};margin:0.3em 0"><b>'
            f"{escape(word)}</b>{joint}{escape(self.rest)}</div>{_bar(self.share)}</div>"
        )


@dataclass(frozen=True)
class SeedResult:
    """Outcome of the simulation of one seed."""

    seed: int  # of its disturbance
    landed: bool  # whether the robot stands at the end
    strict: bool  # whether it landed by the strict measure (`llsrbm.simulation.verdict`)
    fell_at_s: float | None  # when it fell; None if it landed
    foot_error: float  # largest horizontal distance of a foot from the plan's at the end, m
    line: str  # the same in words


def _bar(share: float | None) -> str:
    """A bar that takes the same place when there is none."""
    if share is None:
        return '<div class="llsrbm-progress"></div>'
    done = decimal(100 * min(max(share, 0.0), 1.0))
    return (
        '<div class="llsrbm-progress" role="progressbar" aria-label="Progress" aria-valuemin="0" '
        f'aria-valuemax="100" aria-valuenow="{done}"><div style="width:{done}%"></div></div>'
    )
