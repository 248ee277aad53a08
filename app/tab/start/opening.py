"""The beginning of a tab, and its coming back: kept or shared designs, files, examples."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from app.link import PageReady, PlaybackChosen, PlayerMoved
from app.tab import files
from app.tab.acts import Step, joined, on, submit, submit_beside
from app.tab.comparing import go_on
from app.tab.effects import After, Effect, LoadRobot, Notify, Play, Queue, Seek, SetPlayback
from app.tab.inspection import begin_check
from app.tab.planning.dragging import REST
from app.tab.planning.largest import search
from app.tab.planning.refining import show_given_refined
from app.tab.planning.requests import Rested, plan_design
from app.tab.repairing import check_foreign
from app.tab.shown import Given
from app.tab.state import FileWork, TabState
from app.workers.opened_file import OpenedFile
from app.workers.tasks import Prepare, SimulateSeeds
from llsrbm.motion.plan import Plan
from llsrbm.request.design import Design
from llsrbm.request.jump import Jump
from llsrbm.robots import RobotFile


def first_state(robots: Mapping[str, RobotFile], note: str = "") -> TabState:
    """A tab of which nothing is known yet: the example of the first robot, and a note on it."""
    return TabState(robots, example_design(robots[Jump().robot]), note=note)


def example_design(file: RobotFile) -> Design:
    """The example of a robot."""
    return Design(Jump(robot=file.name, **file.example.model_dump()))


@dataclass(frozen=True, eq=False)
class TabOpened:
    """The tab begins."""

    # which the browser kept, or a link holds; None: the example of the first robot
    design: Design | None = None
    plan: Plan | None = None  # the example's, if it is known
    file: OpenedFile | None = None  # with which every tab of this server begins
    complaints: tuple[str, ...] = ()  # on the design that the browser kept
    time: float = 0.0  # s, where the page's motion was with another server; 0: it had none
    playing: bool = False  # whether it moved


@on(TabOpened)
def open_tab(state: TabState, event: TabOpened) -> Step:
    """Show a jump at once, and plan the design."""
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
    return joined(before, show_given_refined(state, Given(event.plan)))


# ---- coming back


def left(state: TabState) -> TabState:
    """The part of a tab's state that is kept when its connection has ended."""
    shown = state.shown
    if shown is not None and shown.so_far is not None:
        shown = replace(shown, so_far=None)
    return replace(state, shown=shown, page=False, answers=())


def resume(state: TabState, page: PageReady, tickets: int = 0) -> Step:
    """A tab comes back: its jobs begin anew, its place on the timeline is found."""
    if page.time > 0 or page.playing:  # it lost its connection only, and went on by itself
        playback = replace(state.playback, time=page.time, playing=page.playing)
        state = replace(state, playback=playback)
    tickets = max(tickets, state.tickets)
    state = replace(state, tickets=tickets).with_work(dropped=tickets)
    work = state.work
    begun: tuple[Effect, ...] = ()
    if work.awaited is not None:
        if state.seeds is not None and isinstance(work.awaited, SimulateSeeds):
            state = replace(state, seeds=replace(state.seeds, results=()))
        state, begun = submit(state, work.awaited)
    elif state.given is not None:
        begun = (LoadRobot(state.given.plan.jump.robot),)
    elif not state.ready:
        state, begun = plan_design(state)
    if state.moving:
        begun = (*begun, After(REST, Rested(work.dragging.rest)))
    robot = state.robot
    if robot is not None and not state.prepared:
        state, meshes = submit_beside(state, Queue.ROBOT, Prepare(robot.name))
        begun = (*begun, *meshes)
    if state.check is not None and state.check.ticket:
        state, checked = begin_check(state, state.check.motion)
        begun = (*begun, *checked)
    if state.comparing is not None and not state.comparing.done:
        state, tried = go_on(state)
        begun = (*begun, *tried)
    if state.foreign is not None and state.foreign.ticket:
        state, checked = check_foreign(state, state.foreign)
        begun = (*begun, *checked)
    if state.far is not None and state.far.running:
        state, searched = search(state, state.far)
        begun = (*begun, *searched)
    if state.files.opening or state.files.saving:
        state = replace(state, files=FileWork())
        body = "The connection was lost while a file was read or written: please try again."
        begun = (*begun, Notify("Stopped", body))
    if state.shown is None:
        return state, begun
    play = (Play(),) if state.playback.playing else ()
    playback = state.playback
    pace = SetPlayback(playback.speed, playback.loop)
    return state, (*begun, pace, Seek(playback.time), *play)


# ---- the page


@on(PlayerMoved)
def follow_player(state: TabState, event: PlayerMoved) -> TabState:
    """The motion plays, or stands, at another instant."""
    return replace(state, playback=replace(state.playback, time=event.time, playing=event.playing))


@on(PlaybackChosen)
def choose_playback(state: TabState, event: PlaybackChosen) -> TabState:
    """Speed and repetition were chosen."""
    return replace(state, playback=replace(state.playback, speed=event.speed, loop=event.loop))
