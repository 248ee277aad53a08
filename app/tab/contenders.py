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

_BEGINS = "Planning and simulating"


@dataclass(frozen=True, eq=False)
class Contender:
    """One of the ways to make the jump."""

    name: str  # "SRBM", "With replanning"
    design: Design  # request, tuning and scenario
    colour: Rgb  # of its ellipsoid and curves
    plan: Plan | None = None  # once it is there
    shown: Shown | None = None  # its plan and simulation, once they are there
    why_not: str = ""  # there will be none, and why; in one sentence
    ticket: int = 0  # of the job that plans or simulates it; 0: there is none
    note: str = ""  # on that job's progress; "": it has not begun

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
    """Ways that are tried side by side."""

    by: By
    contenders: tuple[Contender, ...]  # from left to right
    plots: PlotChoice  # their charts

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
    def done(self) -> bool:
        """Whether all have been tried."""
        return all(each.done for each in self.contenders)

    def place_of(self, ticket: int) -> int | None:
        """The place of the one that a job is for; None: it is for none any more."""
        places = enumerate(self.contenders)
        return next((place for place, each in places if each.ticket == ticket), None)

    def having(self, place: int, contender: Contender) -> Comparing:
        """With the one of a place as it is by now."""
        contenders = [*self.contenders]
        contenders[place] = contender
        return replace(self, contenders=tuple(contenders))


def card(comparing: Comparing | None) -> dict[str, Any] | None:
    """For the page (static/compare.js): the ways; once all are done a sentence and figures."""
    if comparing is None:
        return None
    ways, done = [each.way for each in comparing.contenders], comparing.done
    notes = [f"{each.name}: {each.note}" for each in comparing.contenders if each.note]
    return {
        "ways": [
            {
                "name": each.name,
                "colour": css(each.colour),
                "state": "done" if each.done else "busy" if each.note else "waits",
            }
            for each in comparing.contenders
        ],
        "note": "" if done else f"{'; '.join(notes) or _BEGINS} ...",
        "sentence": sentence(ways, of_models=comparing.by == "models") if done else "",
        "rows": [{"title": title, "values": values} for title, values in rows(ways)]
        if done
        else [],
    }
