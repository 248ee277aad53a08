"""The registry of events: each feature says beside its functions which events they take.

An event is a member of `Act` where nothing is carried, the press of a button; else a value, known
by its type: what controls or the page say (a `Jump`, a `Scenario`, `PlayerMoved`), or what has been
computed (`Reported`, known by the type of its task). `update(state, event)` makes of it the next
state and effects; nothing there waits, reads a control, or knows of a browser.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from app.panel.acts import Act
from app.panel.panel import Panel
from app.tab.effects import (
    Effect,
    Forget,
    Keep,
    Notify,
    Play,
    Queue,
    Reported,
    Seek,
    SetPlayback,
    Submit,
)
from app.tab.how_far import CHANGED
from app.tab.state import TabState
from app.workers.reports import Partial
from app.workers.tasks import PlanJump, Task

Step = tuple[TabState, tuple[Effect, ...]]
"""A tab's next state, and what has to be done outside of it."""

Condition = Callable[[TabState], bool]
Handler = TypeVar("Handler", bound=Callable[..., "Step | TabState"])
Reader = Callable[[TabState, Panel], tuple[Any, list[str]]]

SLOW_MOTION = 0.25  # seconds of motion a second; one of the speeds that the page offers

_handlers: dict[Act | type, Callable[[TabState, Any], Step | TabState]] = {}
_readers: dict[Act, Reader] = {}
_enabled: dict[Act, Condition] = {}
_visible: dict[Act, Condition] = {}


@dataclass(frozen=True)
class Corrected:
    """An event that was read from controls with values that had to be corrected."""

    event: Any  # with the nearest values
    complaints: tuple[str, ...]  # sentences on them


def on(
    *keys: Act | type, enabled: Condition | None = None, visible: Condition | None = None
) -> Callable[[Handler], Handler]:
    """Have `f(state, event)` take events of a type, reports on tasks of one, or `f(state)` an act.

    The button of an act can be pressed if `enabled`, and is seen if `visible`; None: always.
    """

    def register(handler: Handler) -> Handler:
        for key in keys:
            assert key not in _handlers, f"{key} is taken twice"
            if not isinstance(key, Act):
                _handlers[key] = handler
                continue
            _handlers[key] = lambda state, _: handler(state)
            for conditions, condition in ((_enabled, enabled), (_visible, visible)):
                if condition is not None:
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
    after, effects = _paced(state, _freed(state, _updated(state, event)))
    return after.reaching(after.design.jump), effects


def _updated(state: TabState, event: Any) -> Step:
    if isinstance(event, Corrected):
        return also(update(state, event.event), Notify("Corrected", "; ".join(event.complaints)))
    key = event if isinstance(event, Act) else type(event)
    if isinstance(event, Reported):
        if event.job.queue is Queue.MOTION and _is_stale(state, event):
            return state, ()
        key = type(event.job.task)
        if event.ticket == state.work.newest and not isinstance(event.report, Partial):
            state = state.with_work(awaited=None)
    return _step(_handlers[key](state, event))


def _is_stale(state: TabState, event: Reported) -> bool:
    """Whether a report on the tab's motion does not count any more: it is not of the newest job.

    While a slider moves, the plan for an older request is worth showing.
    """
    work = state.work
    if event.ticket != work.newest:
        return event.ticket <= work.dropped or not isinstance(event.job.task, PlanJump)
    return event.ticket <= work.dropped or work.awaited is None


def is_enabled(act: Act, state: TabState) -> bool:
    """Whether its button can be pressed."""
    return act not in _enabled or _enabled[act](state)


def is_visible(act: Act, state: TabState) -> bool:
    """Whether its button is seen."""
    return act not in _visible or _visible[act](state)


def _freed(before: TabState, step: Step) -> Step:
    """A step after which the pool goes on with no comparison that is closed, and does not look for
    the largest jump beside a request that has changed.
    """
    state, effects = step
    if before.comparing is not None and not before.comparing.done and state.comparing is None:
        effects = (Forget(Queue.COMPARE), *effects)
    if state.far is not None and state.far.running and not state.far.is_of(state.design):
        state = replace(state, far=replace(state.far, ticket=0, why_not=CHANGED))
        effects = (Forget(Queue.LARGEST), *effects)
    return state, effects


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


def submit_beside(state: TabState, queue: Queue, task: Task, lane: int = 0) -> Step:
    """Have the pool work on something else; the job's ticket is the state's newest."""
    state = replace(state, tickets=state.tickets + 1)
    return state, (Submit(queue, state.tickets, task, lane),)


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
