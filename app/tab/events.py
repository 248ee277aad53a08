"""Events of a tab, as values: its visitor's acts, reports of its page and of the pool."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from app.link import (
    AtlasSeen,
    PageReady,
    PlaybackChosen,
    PlayerMoved,
    TuningChosen,
)
from app.panel.atlas_choice import AtlasChoice
from app.panel.export_controls import Choice
from app.plots.choice import PlotChoice
from app.tab.lanes import Lane
from app.workers.opened_file import OpenedFile
from app.workers.protocol import Report
from llsrbm.motion.plan import Plan
from llsrbm.request.design import Design
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from llsrbm.request.tuning import Tuning
from llsrbm.robots import Robot

Complaints = tuple[str, ...]
"""Corrections of values that a browser sent, in words."""


# ---- the visitor asks for something


@dataclass(frozen=True)
class JumpChosen:
    """The controls of the jump were moved.

    Attributes:
        jump: as the controls stand.
        tuning: under other weights and limits; None: they stay.
        complaints: what was corrected.
    """

    jump: Jump
    tuning: Tuning | None
    complaints: Complaints = ()


@dataclass(frozen=True)
class TuningReset:
    """All weights and limits shall be the robot's own."""


@dataclass(frozen=True)
class TargetDragged:
    """The landing handle was dragged.

    Attributes:
        jump: the request with the landing place where it stands now.
    """

    jump: Jump


@dataclass(frozen=True)
class ScenarioChosen:
    """The controls of the scenario were moved.

    Attributes:
        scenario: as the controls stand.
        complaints: what was corrected.
    """

    scenario: Scenario
    complaints: Complaints = ()


@dataclass(frozen=True)
class PushDragged:
    """The push was drawn in the picture.

    Attributes:
        time: s, the instant that was shown.
        impulse: N s, (x, y, z), as the arrow stands.
        ended: whether it was let go of.
    """

    time: float
    impulse: tuple[float, float, float]
    ended: bool


@dataclass(frozen=True)
class DesignChosen:
    """An example was chosen."""

    design: Design


@dataclass(frozen=True)
class AtlasChosen:
    """Another map of the atlas was chosen."""

    choice: AtlasChoice


@dataclass(frozen=True)
class JumpOpened:
    """A jump of the atlas was chosen.

    Attributes:
        jump: the request; tuning: with the limits that its sweep varied.
        other_drives: its sweep had stronger or weaker drives, which a page has not.
    """

    jump: Jump
    tuning: Tuning
    other_drives: bool = False


@dataclass(frozen=True)
class SimulateWanted:
    """The plan shall be followed by the whole robot.

    Attributes:
        seeds: under so many disturbances in turn; 0: once, in the design's scenario.
    """

    seeds: int = 0


@dataclass(frozen=True)
class CompareWanted:
    """What is asked for shall be simulated twice, with one change, and played side by side.

    Attributes:
        by: the change: with and without replanning, or another model.
    """

    by: Literal["replanning", "model"]


@dataclass(frozen=True)
class WorstWanted:
    """Of several seeds the worst one shall be shown."""


@dataclass(frozen=True)
class CancelWanted:
    """Everything that is being computed shall stop."""


@dataclass(frozen=True)
class NearestWanted:
    """The jump on offer shall be taken."""


@dataclass(frozen=True)
class UndoWanted:
    """Back to the design before."""


@dataclass(frozen=True)
class RedoWanted:
    """Forth again."""


@dataclass(frozen=True)
class ViewChosen:
    """Overlays and light were chosen.

    Attributes:
        layers: names of overlays.
        night: a dark page.
    """

    layers: frozenset[str]
    night: bool


@dataclass(frozen=True)
class PlotsChosen:
    """Charts were chosen."""

    choice: PlotChoice


@dataclass(frozen=True)
class PinWanted:
    """The motion that is shown shall be kept beside the next ones."""


@dataclass(frozen=True)
class PinChosen:
    """A pin was chosen.

    Attributes:
        index: its number, -1: none.
    """

    index: int


@dataclass(frozen=True)
class UnpinWanted:
    """The chosen pin shall go."""


@dataclass(frozen=True)
class TakeUpWanted:
    """The design of the chosen pin shall become the present one."""


@dataclass(frozen=True, eq=False)
class FileChosen:
    """A file was opened, whatever it is.

    Attributes:
        name: as the browser has it.
        content: of the file.
        rate: frames/s, where the file does not say its own.
    """

    name: str
    content: bytes
    rate: float


@dataclass(frozen=True)
class SaveWanted:
    """The design shall be saved."""


@dataclass(frozen=True)
class ShareWanted:
    """A link that opens the design shall be made."""


@dataclass(frozen=True)
class ExportWanted:
    """The motion shall be saved.

    Attributes:
        choice: of what, in which formats.
        complaints: what was corrected.
    """

    choice: Choice
    complaints: Complaints = ()


@dataclass(frozen=True)
class StopExportWanted:
    """The file that is being saved is not wanted any more."""


# ---- computing and loading


@dataclass(frozen=True, eq=False)
class Reported:
    """A job has something to report.

    Attributes:
        lane: in which it runs.
        ticket: by which the state knows it.
        report: the pool's.
    """

    lane: Lane
    ticket: int
    report: Report


@dataclass(frozen=True, eq=False)
class RobotLoaded:
    """A robot can be drawn.

    Attributes:
        robot: that can be.
        prepared: its meshes are there; else its collision shapes stand in for them.
    """

    robot: Robot
    prepared: bool = True


@dataclass(frozen=True)
class RobotMissing:
    """A robot cannot be drawn.

    Attributes:
        robot: its name.
        message: why not.
    """

    robot: str
    message: str


@dataclass(frozen=True)
class Rested:
    """A request has rested for as long as was asked.

    Attributes:
        number: of the rest, see `DragPlanning`.
    """

    number: int


@dataclass(frozen=True)
class Remarked:
    """Something has happened to what computes, of which every tab should know.

    Attributes:
        remark: in a sentence.
    """

    remark: str


@dataclass(frozen=True, eq=False)
class Opened:
    """The tab begins.

    Attributes:
        design: which the browser kept, or a link holds; None: the example of the first robot.
        plan: the example's, if it is known.
        file: with which every tab of this server begins.
        complaints: what was wrong with the design that the browser kept.
        time: s, where the page's motion was with another server; 0: it had none.
        playing: whether it moved.
    """

    design: Design | None = None
    plan: Plan | None = None
    file: OpenedFile | None = None
    complaints: Complaints = ()
    time: float = 0.0
    playing: bool = False


Event = (
    JumpChosen
    | TuningReset
    | TargetDragged
    | ScenarioChosen
    | PushDragged
    | DesignChosen
    | AtlasChosen
    | AtlasSeen
    | JumpOpened
    | SimulateWanted
    | CompareWanted
    | WorstWanted
    | CancelWanted
    | NearestWanted
    | UndoWanted
    | RedoWanted
    | ViewChosen
    | PlotsChosen
    | PinWanted
    | PinChosen
    | UnpinWanted
    | TakeUpWanted
    | FileChosen
    | SaveWanted
    | ShareWanted
    | ExportWanted
    | StopExportWanted
    | Reported
    | RobotLoaded
    | RobotMissing
    | Rested
    | Remarked
    | Opened
    | PageReady
    | PlayerMoved
    | PlaybackChosen
    | TuningChosen
)
