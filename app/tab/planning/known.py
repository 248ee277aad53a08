"""Motions of designs that were there before: shown again to the last bit, without planning."""

from dataclasses import replace

from app.panel import summaries
from app.tab.acts import Step, joined, submit
from app.tab.effects import Effect, Keep, Queue, Stop
from app.tab.shown import Shown
from app.tab.simulating import simulate_again
from app.tab.state import TabState
from app.workers import tasks

_MOST = 24  # motions, some megabytes together


def with_answer(state: TabState) -> TabState:
    """The state that remembers the motion of its design, if that is there, to come back to."""
    shown, request = state.shown, (state.design.jump, state.design.tuning)
    if shown is None or shown.source or shown.so_far or state.planning or not shown.plan.solved:
        return state
    if (shown.request, shown.plan.tuning) != request:
        return state
    others = [each for each in state.answers if each[0] != request]
    return replace(state, answers=(*others, (request, shown))[-_MOST:])


def answer_of(state: TabState) -> Shown | None:
    """The motion of the state's design that was there before; None: none is remembered."""
    request = state.design.jump, state.design.tuning
    return next((shown for known, shown in state.answers if known == request), None)


def show_again(state: TabState, shown: Shown) -> Step:
    """Show a motion of the present design; what is a draft yet is followed by the whole body's."""
    work, design = state.work, state.design
    stop: tuple[Effect, ...] = () if work.awaited is None else (Stop(Queue.MOTION),)
    dragging = work.dragging.done(design.jump, design.tuning)
    state = state.without_sequel().with_work(awaited=None, dropped=work.newest, dragging=dragging)
    status = summaries.plan_status(shown.plan, shown.source, shown.wanted, shown.reason)
    if shown.rollout is not None:
        status = summaries.simulated_status(shown.rollout, shown.source)
    state = replace(state, shown=shown, given=None, seeds=None, status=status)
    if state.whole_body and shown.plan.refinement is None:
        state = replace(state, status=replace(status, busy=True))
        return joined(
            (*stop, Keep(design)), submit(state, tasks.RefinePlan(shown.plan, shown.request))
        )
    return joined((*stop, Keep(design)), simulate_again(state))
