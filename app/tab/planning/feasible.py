"""The part of each slider that can be planned, with the other values as they are.

A robot's table of solved jumps says it (`llsrbm.atlas.tracks`); what this tab has planned, and
what was refused, corrects it.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from app.link import PageLink
from app.panel.jump_controls import TINTED
from app.tab.state import TabState
from app.workers.reports import FoundLargest, Planned, Refused, Report
from app.workers.tasks import FindLargest, PlanJump, RefinePlan, Task
from llsrbm.atlas.tracks import Track, learned, tracks, why_unknown
from llsrbm.motion.plan import Plan
from llsrbm.number_text import short
from llsrbm.planning.whole_body.feasible import feasible_of
from llsrbm.request.jump import Jump
from llsrbm.request.tuning import Tuning

_SLACK = 1e-6  # of a range: ends that are the same in other units differ in their last bits


def learn(state: TabState, report: Report, task: Task) -> TabState:
    """The state with what an outcome says of the requests around it; a draft says nothing."""
    robot, (tuning, outcomes) = state.robot, _outcomes(report, task)
    if robot is None or any(jump.robot != robot.name for jump in outcomes):
        return state
    found = state.feasible.get(robot.name) or feasible_of(robot)
    if found is None or not outcomes:
        return state
    for jump, planned in outcomes.items():
        found = learned(found, jump, tuning.limits, robot, planned=planned)
    return replace(state, feasible={**state.feasible, robot.name: found})


def _outcomes(report: Report, task: Task) -> tuple[Tuning, dict[Jump, bool]]:
    """Whether a plan of a jump was found whose certificate holds, and with which tuning."""
    match task, report:
        case RefinePlan(plan=draft, wanted=wanted), Planned(plan=plan):
            return draft.tuning, {wanted: False} | ({plan.jump: True} if plan.certified else {})
        case FindLargest(), FoundLargest(largest=found):
            return task.tuning, {found.plan.jump: True}
        case RefinePlan(plan=draft, wanted=wanted), Refused(nearest=Plan() as less):
            return draft.tuning, {wanted: False, less.jump: True}
        case PlanJump(), Planned(plan=plan) if plan.certified:
            return task.tuning, {plan.jump: True}
        case PlanJump(jump=jump, patient=True), Refused():
            return task.tuning, {jump: False}
    return Tuning(), {}


class Tint:
    """One tab's tracks of sliders; for the session's thread. It knows what was drawn last."""

    def __init__(self, link: PageLink, sliders: Mapping[str, str]) -> None:
        """`sliders`: field of a request -> the uuid of its slider."""
        self._link, self._sliders = link, sliders
        self._made_of: tuple[Any, ...] = ()

    def draw(self, state: TabState) -> None:
        """Tint the tracks anew, if they are of another request."""
        if not state.ready or state.robot is None:
            if self._made_of:  # of another robot
                self._made_of = ()
                self._link.call("tint.show", dict.fromkeys(self._sliders.values(), _unknown_yet()))
            return
        design = state.design
        made_of = (
            design.jump,
            design.tuning.limits,
            state.robot,
            state.feasible.get(state.robot.name),
            state.ends,
        )
        if made_of == self._made_of:
            return
        self._made_of = made_of
        jump, limits, robot, feasible, ends = made_of
        found, why = tracks(jump, limits, robot, feasible), why_unknown(jump, limits, robot)
        self._link.call(
            "tint.show",
            {
                uuid: {
                    "chances": chances(found[name], getattr(ends, name)) if name in found else [],
                    "text": in_words(name, jump, found[name], getattr(ends, name))
                    if name in found
                    else unknown(why),
                    "range": "  ".join(_ranges(name, jump, found[name])) if name in found else "",
                }
                for name, uuid in self._sliders.items()
            },
        )


def chances(track: Track, ends: tuple[float, float]) -> list[int | None]:
    """In per cent, evenly over a slider with these ends; None beyond what is known."""
    values, known = np.linspace(*ends, len(track.values)), track.values
    scores = np.interp(values, known, track.scores).clip(-30, 30)
    shares = np.round(100 / (1 + np.exp(-scores))).astype(int).tolist()
    slack = _SLACK * (known[-1] - known[0])
    inside = (values >= known[0] - slack) & (values <= known[-1] + slack)
    return [share if there else None for share, there in zip(shares, inside, strict=True)]


def _unknown_yet() -> dict[str, Any]:
    """The plain track of a slider while the robot is loaded."""
    return {"chances": [], "text": unknown("before the robot is loaded"), "range": ""}


def unknown(why: str) -> str:
    """The sentence on a slider without a tint."""
    return f"Which values can be planned is not known {why}"


def in_words(name: str, jump: Jump, track: Track, ends: tuple[float, float]) -> str:
    """The sentence on a slider with these ends, in its units."""
    known = track.values[0], track.values[-1]
    if track.intervals == (known,) and None not in chances(track, ends):
        return "Can be planned over the whole slider, with the other values as they are"
    parts = _ranges(name, jump, track)
    if not parts:
        return "Can be planned nowhere along this slider, with the other values as they are"
    return f"Can be planned from {' and from '.join(parts)}, with the other values as they are"


def _ranges(name: str, jump: Jump, track: Track) -> list[str]:
    """The stretches of a slider that can be planned, in its units."""

    def shown(end: Any) -> str:
        return short(TINTED[name].shown(replace(jump, **{name: end})))

    return [f"{shown(low)} to {shown(high)}" for low, high in track.intervals]
