"""From what a visitor did to an event: the controls are read as they stand now."""

from __future__ import annotations

from app.panel.actions import Action
from app.panel.panel import Panel
from app.tab.events import (
    AtlasChosen,
    CancelWanted,
    CompareWanted,
    Event,
    ExportWanted,
    JumpChosen,
    NearestWanted,
    PinChosen,
    PinWanted,
    RedoWanted,
    SaveWanted,
    ScenarioChosen,
    ShareWanted,
    SimulateWanted,
    StopExportWanted,
    TakeUpWanted,
    TuningReset,
    UndoWanted,
    UnpinWanted,
    ViewChosen,
    WorstWanted,
)
from app.tab.requests import SEEDS
from app.tab.state import TabState

_WITHOUT_VALUES: dict[Action, Event] = {
    Action.SIMULATE: SimulateWanted(),
    Action.SEEDS: SimulateWanted(SEEDS),
    Action.COMPARE_REPLANNING: CompareWanted("replanning"),
    Action.COMPARE_MODEL: CompareWanted("model"),
    Action.WORST: WorstWanted(),
    Action.CANCEL: CancelWanted(),
    Action.NEAREST: NearestWanted(),
    Action.RESET_TUNING: TuningReset(),
    Action.UNDO: UndoWanted(),
    Action.REDO: RedoWanted(),
    Action.SHARE: ShareWanted(),
    Action.PIN: PinWanted(),
    Action.UNPIN: UnpinWanted(),
    Action.TAKE_UP: TakeUpWanted(),
    Action.SAVE: SaveWanted(),
    Action.STOP_EXPORT: StopExportWanted(),
}

READ_ACTIONS = frozenset(
    {Action.JUMP, Action.SCENARIO, Action.VIEW, Action.ATLAS, Action.PIN_CHOSEN}
)
"""Those that mean how controls stand, however often they were moved."""


def event_of(action: Action, state: TabState, panel: Panel) -> Event:
    """The event that an action means, given where the controls stand.

    Args:
        action: what was done.
        state: that is drawn.
        panel: to be read.
    """
    match action:
        case Action.JUMP:
            jump, wrong = panel.jump.read(state.design.jump)
            return JumpChosen(jump, None, tuple(wrong))
        case Action.SCENARIO:
            scenario, wrong = panel.simulation.read(state.design.scenario)
            return ScenarioChosen(scenario, tuple(wrong))
        case Action.VIEW:
            return ViewChosen(*panel.view.read())
        case Action.ATLAS:
            return AtlasChosen(panel.atlas.read(state.atlas))
        case Action.PIN_CHOSEN:
            return PinChosen(panel.compare.chosen)
        case Action.EXPORT:
            choice, wrong = panel.export_options.read()
            return ExportWanted(choice, tuple(wrong))
        case _:
            return _WITHOUT_VALUES[action]
