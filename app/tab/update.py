"""How events change a tab: `update(state, event) -> (state, effects)`, a pure function.

    request -> plan -> postures -> simulation -> replay -> file

A visitor's request, and each result on this way, is an event (`events`); what it makes of the state
is said here and in the modules that are named after what happens; what has to be done outside of
the state comes out as effects (`effects`), which `session` carries out. Nothing here waits, reads a
control, or knows of a browser.
"""

from __future__ import annotations

from dataclasses import replace

from app.link import (
    AtlasSeen,
    PageReady,
    PlaybackChosen,
    PlayerMoved,
    TuningChosen,
)
from app.tab import files, push_comparison, pushing, requests, results
from app.tab.effects import LoadRobot, Notify, Share, Stop
from app.tab.events import (
    AtlasChosen,
    CancelWanted,
    CompareWanted,
    DesignChosen,
    Event,
    ExportWanted,
    FileChosen,
    JumpChosen,
    JumpOpened,
    NearestWanted,
    Opened,
    PinChosen,
    PinWanted,
    PlotsChosen,
    PushDragged,
    RedoWanted,
    Remarked,
    Reported,
    Rested,
    RobotLoaded,
    RobotMissing,
    SaveWanted,
    ScenarioChosen,
    ShareWanted,
    SimulateWanted,
    StopExportWanted,
    TakeUpWanted,
    TargetDragged,
    TuningReset,
    UndoWanted,
    UnpinWanted,
    ViewChosen,
    WorstWanted,
)
from app.tab.known_motion import show_known
from app.tab.lanes import Lane
from app.tab.opening import open_tab
from app.tab.state import TabState
from app.tab.steps import Step, joined
from app.workers.protocol import Failed, Prepared


def update(state: TabState, event: Event) -> Step:
    """A tab's state after an event, and what has to be done outside of it."""
    match event:
        case JumpChosen():
            return requests.choose_jump(state, event)
        case TuningChosen():
            return requests.choose_tuning(state, event)
        case TuningReset():
            return requests.reset_tuning(state)
        case TargetDragged():
            return requests.drag_target(state, event)
        case ScenarioChosen():
            return pushing.choose_scenario(state, event)
        case PushDragged():
            return pushing.drag_push(state, event)
        case DesignChosen():
            return requests.choose_design(state, event)
        case JumpOpened():
            return requests.open_jump(state, event)
        case NearestWanted():
            return requests.take_nearest(state)
        case UndoWanted():
            return requests.undo(state)
        case RedoWanted():
            return requests.redo(state)
        case Rested():
            return requests.rest(state, event)
        case SimulateWanted():
            return requests.simulate(state, event)
        case CompareWanted():
            return push_comparison.compare(state, event)
        case WorstWanted():
            return results.show_worst(state)
        case CancelWanted():
            return requests.cancel(state)
        case Reported(lane=Lane.MOTION):
            return results.take_report(state, event)
        case RobotLoaded():
            return _robot_loaded(state, event)
        case Reported(lane=Lane.ROBOT):
            return _prepared(state, event)
        case RobotMissing():
            return results.miss_robot(state, event)
        case Opened():
            return open_tab(state, event)
        case _:
            return _update_beside(state, event)


def _update_beside(state: TabState, event: Event) -> Step:
    """Events that change neither the request nor what is computed of it."""
    match event:
        case FileChosen():
            return files.open_file(state, event)
        case Reported(lane=Lane.OPEN):
            return files.take_opening(state, event)
        case SaveWanted():
            return files.save_design(state)
        case ExportWanted():
            return files.export(state, event)
        case Reported(lane=Lane.SAVE):
            return files.take_saving(state, event)
        case StopExportWanted():
            return state, (Stop(Lane.SAVE),)
        case ShareWanted():
            return state, (Share(state.design),)
        case PinWanted():
            return push_comparison.pin(state), ()
        case PinChosen(index):
            return replace(state, pin_chosen=index if index < len(state.pins) else -1), ()
        case UnpinWanted():
            return _unpin(state), ()
        case TakeUpWanted():
            return _take_up(state)
        case Remarked(remark):
            return state, (Notify("The server", remark),)
        case ViewChosen(layers, night):
            return replace(state, view=replace(state.view, layers=layers, night=night)), ()
        case AtlasChosen(choice):
            return replace(state, atlas=choice), ()
        case AtlasSeen():
            return replace(state, atlas=replace(state.atlas, seen=True)), ()
        case PlotsChosen(choice):
            return replace(state, plots=choice), ()
        case PageReady(software=software):
            return replace(state, page=True, view=replace(state.view, fine=not software)), ()
        case PlayerMoved(time, playing):
            return replace(state, playback=replace(state.playback, time=time, playing=playing)), ()
        case PlaybackChosen(speed, loop):
            return replace(state, playback=replace(state.playback, speed=speed, loop=loop)), ()
    return state, ()


def _robot_loaded(state: TabState, event: RobotLoaded) -> Step:
    if event.robot is state.robot and event.prepared and not state.prepared:
        return replace(state, prepared=True), ()  # its meshes have been made
    known = state.known
    if known is None or known.plan.jump.robot != event.robot.name:
        return results.take_robot(state, event)
    state, effects = results.draw_robot(state, event)
    return joined(effects, show_known(state, known))


def _prepared(state: TabState, event: Reported) -> Step:
    """The meshes of a robot that is drawn by its collision shapes have been made."""
    match event.report:
        case Prepared(robot=name) if state.robot is not None and state.robot.name == name:
            return state, (LoadRobot(name),)
        case Failed(message=message):
            return state, (Notify("The robot's meshes are missing", message),)
    return state, ()


# ---- what is compared


def _unpin(state: TabState) -> TabState:
    """Let go of the pin that is chosen."""
    chosen = state.pin_chosen
    pins = tuple(pin for index, pin in enumerate(state.pins) if index != chosen)
    return replace(state, pins=pins, pin_chosen=len(pins) - 1)


def _take_up(state: TabState) -> Step:
    """Make the design of the chosen pin the present one."""
    chosen = state.pin_chosen
    if not 0 <= chosen < len(state.pins):
        return state, ()
    design = state.pins[chosen].design
    if design is None:
        body = "A motion of another tool is for looking: nothing says what was asked for."
        return state, (Notify("Not taken up", body),)
    return requests.choose_design(state, DesignChosen(design))
