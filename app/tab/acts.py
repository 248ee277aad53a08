"""The registry of events: each feature says beside its functions which events they take.

An event is a member of `Act` where nothing is carried, the press of a button; else a value, known
by its type: what controls or the page say (a `Jump`, a `Scenario`, `PlayerMoved`), or what has been
computed (`Reported`, by its queue, and then by its task). `update(state, event)` makes of it the
next state and effects; nothing there waits, reads a control, or knows of a browser.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from app.panel.acts import Act
from app.panel.panel import Panel
from app.tab.effects import (
    Effect,
    Keep,
    Notify,
    Play,
    Queue,
    Reported,
    Seek,
    SetPlayback,
    Submit,
)
from app.tab.state import TabState
from app.workers.tasks import Task

Step = tuple[TabState, tuple[Effect, ...]]
"""A tab's next state, and what has to be done outside of it."""

Condition = Callable[[TabState], bool]
Handler = TypeVar("Handler", bound=Callable[..., "Step | TabState"])
Reader = Callable[[TabState, Panel], tuple[Any, list[str]]]

SLOW_MOTION = 0.25  # seconds of motion a second; one of the speeds that the page offers

_handlers: dict[Any, Callable[..., Step | TabState]] = {}
_readers: dict[Act, Reader] = {}
_enabled: dict[Act, Condition] = {}
_visible: dict[Act, Condition] = {}


@dataclass(frozen=True)
class Corrected:
    """An event that was read from controls with values that had to be corrected."""

    event: Any  # with the nearest values
    complaints: tuple[str, ...]  # sentences on them


def on(
    *keys: Any, enabled: Condition | None = None, visible: Condition | None = None
) -> Callable[[Handler], Handler]:
    """Have a function take events: `f(state)` those of an `Act`, else `f(state, event)`.

    Keys are acts, types of values, queues; or types of tasks: `f(state, report, task)`. The button
    of an act can be pressed if `enabled`, and is seen if `visible`; None: always.
    """

    def register(handler: Handler) -> Handler:
        for key in keys:
            assert key not in _handlers, f"{key} is taken twice"
            _handlers[key] = handler
            for conditions, condition in ((_enabled, enabled), (_visible, visible)):
                if condition is not None and isinstance(key, Act):
                    conditions[key] = condition
        return handler

    return register


def reads(act: Act, reader: Reader) -> None:
    """Have a function read the controls of an act: an event, and what had to be corrected."""
    _readers[act] = reader


def keeps(kind: type, field: str) -> None:
    """Have values of a type kept in a field of the state, by nothing else."""
    on(kind)(lambda state, value: replace(state, **{field: value}))


def event_of(act: Act, state: TabState, panel: Panel) -> Any:
    """The event that an act means, given where the controls stand."""
    if act not in _readers:
        return act
    event, complaints = _readers[act](state, panel)
    return Corrected(event, tuple(complaints)) if complaints else event


def update(state: TabState, event: Any) -> Step:
    """A tab's state after an event, and what has to be done outside of it."""
    return _paced(state, _updated(state, event))


def _updated(state: TabState, event: Any) -> Step:
    if isinstance(event, Act):
        return _step(_handlers[event](state))
    if isinstance(event, Reported):
        return _step(_handlers[event.queue](state, event))
    if isinstance(event, Corrected):
        return also(update(state, event.event), Notify("Corrected", "; ".join(event.complaints)))
    return _step(_handlers[type(event)](state, event))


def outcome(state: TabState, report: Any, task: Task) -> Step:
    """A tab's state after a report on a task on its motion."""
    return _step(_handlers[type(task)](state, report, task))


def is_enabled(act: Act, state: TabState) -> bool:
    """Whether its button can be pressed."""
    return act not in _enabled or _enabled[act](state)


def is_visible(act: Act, state: TabState) -> bool:
    """Whether its button is seen."""
    return act not in _visible or _visible[act](state)


def _paced(before: TabState, step: Step) -> Step:
    """A step that goes to a flip or from one also goes to slow motion, unless another pace is set.

    A flip turns the body over in half a second.
    """
    state, effects = step
    turns = state.design.jump.turns
    usual, wanted = (1.0, SLOW_MOTION) if turns else (SLOW_MOTION, 1.0)
    if turns == before.design.jump.turns or state.playback.speed != usual:
        return step
    playback = replace(state.playback, speed=wanted)
    return replace(state, playback=playback), (*effects, SetPlayback(wanted, playback.loop))


def _step(result: Step | TabState) -> Step:
    return (result, ()) if isinstance(result, TabState) else result


# ---- steps


def submit(state: TabState, task: Task) -> Step:
    """Have the pool work on the tab's motion, in place of what it was to do before."""
    state, effects = submit_beside(state, Queue.MOTION, task)
    return state.with_work(newest=state.tickets, awaited=task), effects


def submit_beside(state: TabState, queue: Queue, task: Task) -> Step:
    """Have the pool work on something else; the job's ticket is the state's newest."""
    state = replace(state, tickets=state.tickets + 1)
    return state, (Submit(queue, state.tickets, task),)


def played_first(state: TabState) -> tuple[Effect, ...]:
    """How a tab's first motion is played: from its start, or from where its page was before."""
    time, playing = state.playback.time, state.playback.playing
    if time == 0.0:
        return (Play(),)
    return (Seek(time), Play()) if playing else (Seek(time),)


def kept(state: TabState) -> Step:
    """Have the browser keep the design."""
    return state, (Keep(state.design),)


def also(step: Step, *effects: Effect) -> Step:
    """A step with further effects."""
    state, before = step
    return state, (*before, *effects)


def joined(before: tuple[Effect, ...], step: Step) -> Step:
    """A step that follows another one, whose effects come first."""
    state, after = step
    return state, (*before, *after)
