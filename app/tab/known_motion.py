"""Motions that are there already: from a file, or the plan with which a tab begins."""

from __future__ import annotations

from dataclasses import replace

from app.panel import summaries
from app.panel.status import Word
from app.tab.effects import Keep, LoadRobot
from app.tab.requests import show_plan
from app.tab.results import show_rollout
from app.tab.state import Known, TabState
from app.tab.steps import Step, played_first, with_status, with_work, without_sequel


def show_known(state: TabState, known: Known) -> Step:
    """Show a motion as if it had been planned just now, as soon as its robot can be drawn.

    Args:
        state: of a tab whose design asks for that motion.
        known: the motion; the next plan may start from it.
    """
    plan, robot = known.plan, state.robot
    if robot is None or robot.name != plan.jump.robot:
        return replace(state, known=known), (LoadRobot(plan.jump.robot),)
    play = played_first(state) if state.shown is None else ()
    work = state.work
    dragging, _ = work.dragging.forget().request(plan.jump, plan.tuning, None)
    state = with_work(
        replace(without_sequel(state), known=None, note=known.note or state.note),
        awaited=None,
        dropped=work.newest,
        dragging=dragging,
        nearest=None,
    )
    state = show_plan(state, plan, robot, known.source)
    said = f"{known.source}: " if known.source else ""
    if known.rollout is not None:
        state = show_rollout(state, known.rollout, said)
    elif plan.solved:
        state = with_status(state, Word.PLANNED, said + summaries.planned_line(plan))
    else:
        worst = summaries.worst(plan.violations)
        line = f"{said}the planner did not converge, largest violation {worst}."
        state = with_status(state, Word.FAILED, line)
    return state, (Keep(state.design), *play)
