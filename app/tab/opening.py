"""How a tab begins: with a kept design, a shared one, a file, or the example of the first robot."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from app.link import PageReady
from app.tab import files
from app.tab.drag_planning import REST
from app.tab.effects import After, Effect, LoadRobot, Notify, Play, Seek, SetPlayback, Submit
from app.tab.events import Opened, Rested
from app.tab.known_motion import show_known
from app.tab.lanes import Lane
from app.tab.requests import plan_design
from app.tab.state import FileWork, Known, TabState
from app.tab.steps import Step, joined, submit, with_work
from app.workers.protocol import Prepare, SimulateSeeds
from llsrbm.request.design import Design
from llsrbm.request.jump import Jump
from llsrbm.robots import RobotFile


def first_state(robots: Mapping[str, RobotFile]) -> TabState:
    """A tab of which nothing is known yet: the example of the first robot is asked for."""
    return TabState(robots, example_design(robots[Jump().robot]))


def example_design(file: RobotFile) -> Design:
    """The jump that shows what a robot can do."""
    return Design(Jump(robot=file.name, **file.example.model_dump()))


def open_tab(state: TabState, event: Opened) -> Step:
    """Show a jump at once, and have planned what is asked for."""
    before: tuple[Effect, ...] = ()
    playback = replace(state.playback, time=event.time, playing=event.playing)
    state = replace(state, playback=playback)
    if event.complaints:
        line = "; ".join(event.complaints)
        before = (Notify("The last design was not opened", line),)
    if event.file is not None:
        if event.file.is_alone:  # beside the example of its robot
            state = replace(state, design=example_design(state.robots[event.file.robot]))
        return joined(before, files.show_file(state, event.file))
    if event.design is not None and event.design != state.design:
        return joined(before, plan_design(replace(state, design=event.design)))
    if event.plan is None:
        return joined(before, plan_design(state))
    return joined(before, show_known(state, Known(event.plan)))


# ---- coming back


def left(state: TabState) -> TabState:
    """The part of a tab's state that is kept when its connection has ended."""
    shown = state.shown
    if shown is not None and shown.so_far is not None:
        shown = replace(shown, so_far=None)
    return replace(state, shown=shown, files=FileWork(), page=False)


def resume(state: TabState, page: PageReady, tickets: int = 0) -> Step:
    """A tab that comes back: its running job is begun anew, its place on the timeline found.

    Args:
        state: that it left.
        page: its greeting.
        tickets: of jobs that were begun before the tab was known; they count for nothing.
    """
    if page.time > 0 or page.playing:  # it lost its connection only, and went on by itself
        playback = replace(state.playback, time=page.time, playing=page.playing)
        state = replace(state, playback=playback)
    tickets = max(tickets, state.tickets)
    state = with_work(replace(state, tickets=tickets), dropped=tickets)
    work = state.work
    begun: tuple[Effect, ...] = ()
    if work.awaited is not None:
        if state.seeds is not None and isinstance(work.awaited, SimulateSeeds):
            state = replace(state, seeds=replace(state.seeds, results=()))
        state, begun = submit(state, work.awaited)
    elif state.known is not None:
        begun = (LoadRobot(state.known.plan.jump.robot),)
    elif not state.ready:
        state, begun = plan_design(state)
    elif work.dragging.rests:
        begun = (After(REST, Rested(work.dragging.rest)),)
    robot = state.robot
    if robot is not None and not state.prepared:
        ticket = state.tickets + 1
        state = replace(state, tickets=ticket)
        begun = (*begun, Submit(Lane.ROBOT, ticket, Prepare(robot.name)))
    if state.shown is None:
        return state, begun
    play = (Play(),) if state.playback.playing else ()
    playback = state.playback
    pace = SetPlayback(playback.speed, playback.loop)
    return state, (*begun, pace, Seek(playback.time), *play)
