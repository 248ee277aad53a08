"""Small changes that several parts of `update` make: a job more, another status, a note."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from app.panel.status import Status, Word
from app.tab.effects import Effect, Play, Seek, Submit
from app.tab.lanes import Lane
from app.tab.state import TabState
from app.workers.task import Task

Step = tuple[TabState, tuple[Effect, ...]]
"""A tab's next state, and what has to be done outside of it."""


def with_work(state: TabState, **changes: Any) -> TabState:
    """Other values of `Work`."""
    return replace(state, work=replace(state.work, **changes))


def with_files(state: TabState, **changes: Any) -> TabState:
    """Other values of `FileWork`."""
    return replace(state, files=replace(state.files, **changes))


def with_status(
    state: TabState, word: Word, rest: str, *, busy: bool = False, share: float | None = None
) -> TabState:
    """Another status line."""
    return replace(state, status=Status(word, rest, busy, share))


def without_sequel(state: TabState) -> TabState:
    """What was to follow the plan or the simulation that is awaited is not wanted any more."""
    return with_work(state, simulate_next=None, replay_from=None, compare=None)


def submit(state: TabState, task: Task) -> Step:
    """Have the pool work on the tab's motion, in place of what it was to do before."""
    ticket = state.tickets + 1
    state = with_work(replace(state, tickets=ticket), newest=ticket, awaited=task)
    return state, (Submit(Lane.MOTION, ticket, task),)


def played_first(state: TabState) -> tuple[Effect, ...]:
    """How a tab's first motion is played: from its start, or from where its page was before."""
    time, playing = state.playback.time, state.playback.playing
    if time == 0.0:
        return (Play(),)
    return (Seek(time), Play()) if playing else (Seek(time),)


def also(step: Step, *effects: Effect) -> Step:
    """A step with further effects."""
    state, before = step
    return state, (*before, *effects)


def joined(before: tuple[Effect, ...], step: Step) -> Step:
    """A step that follows another one, whose effects come first."""
    state, after = step
    return state, (*before, *after)
