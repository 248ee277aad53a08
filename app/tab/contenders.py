"""One jump made in several ways beside each other, as a value: what is compared, as far as it is
there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

from app.motion.baked import SimulatedMotion
from app.motion.colours import Rgb
from app.plots.choice import PlotChoice
from app.tab.shown import Shown
from llsrbm.analysis.side_by_side import Way, rows, sentence
from llsrbm.look.palette import css
from llsrbm.motion.plan import Plan
from llsrbm.request.design import Design

By = Literal["models", "arms", "replanning", "drives"]
"""What differs."""

_BEGINS = "planning and simulating"


@dataclass(frozen=True, eq=False)
class Contender:
    """One of the ways to make the jump."""

    name: str  # "SRBM", "With replanning"
    design: Design  # request, tuning and scenario
    colour: Rgb  # of its ellipsoid and curves
    plan: Plan | None = None  # that is there already
    shown: Shown | None = None  # its plan and simulation, once they are there
    why_not: str = ""  # there will be none, and why; in one sentence

    @property
    def done(self) -> bool:
        """Whether it has been tried."""
        return self.shown is not None or bool(self.why_not)

    @property
    def solid(self) -> Shown:
        """Its motion, which is there."""
        assert self.shown is not None
        return self.shown

    @property
    def simulated(self) -> SimulatedMotion:
        """Its simulation, which is there."""
        assert self.solid.simulated is not None
        return self.solid.simulated

    @property
    def way(self) -> Way:
        """It for the sentence and the table."""
        rollout = None if self.shown is None else self.shown.rollout
        return Way(self.name, rollout, self.why_not)


@dataclass(frozen=True, eq=False)
class Comparing:
    """Ways that are tried one after the other."""

    by: By
    contenders: tuple[Contender, ...]  # from left to right
    plots: PlotChoice  # their charts
    ticket: int = 0  # of the job that tries the next one; 0: there is none
    note: str = ""  # on its progress

    @property
    def present(self) -> tuple[Contender, ...]:
        """Those whose motions are there."""
        return tuple(each for each in self.contenders if each.shown is not None)

    @property
    def last(self) -> Contender | None:
        """The rightmost of these; None: there is none yet."""
        present = self.present
        return present[-1] if present else None

    @property
    def following(self) -> Contender | None:
        """The one that is tried, or to be tried next; None: all have been."""
        return next((each for each in self.contenders if not each.done), None)

    def with_tried(self, contender: Contender) -> Comparing:
        """With the one that was to be tried as it is by now."""
        before = self.following
        contenders = tuple(contender if each is before else each for each in self.contenders)
        return replace(self, contenders=contenders, ticket=0, note="")


def card(comparing: Comparing | None) -> dict[str, Any] | None:
    """For the page (static/compare.js): the ways; once all are done a sentence and figures."""
    if comparing is None:
        return None
    ways, following = [each.way for each in comparing.contenders], comparing.following
    done = following is None
    return {
        "ways": [
            {
                "name": each.name,
                "colour": css(each.colour),
                "state": "done" if each.done else "busy" if each is following else "waits",
            }
            for each in comparing.contenders
        ],
        "note": "" if following is None else f"{following.name}: {comparing.note or _BEGINS} ...",
        "sentence": sentence(ways, of_models=comparing.by == "models") if done else "",
        "rows": [{"title": title, "values": values} for title, values in rows(ways)]
        if done
        else [],
    }
