"""Everything that is known of one tab, as a value: `TabState`.

Nothing else holds a fact about a tab. Events change it (`app.tab.update`), the picture, the
panel and the plots are drawn from it (`app.tab.rendering`), and it is what stays for some
minutes when a connection ends (`app.tab.tabs`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from app.motion.frames import Frames
from app.motion.planned_motion import PlannedMotion
from app.motion.simulated_motion import SimulatedMotion
from app.panel.atlas_choice import AtlasChoice
from app.panel.status import Status, Word
from app.picture.overlays import AT_FIRST
from app.plots.choice import DEFAULT, PlotChoice
from app.tab.comparison import Pin
from app.tab.drag_planning import DragPlanning
from app.workers.protocol import Nearest, PlanJump, SeedResult
from app.workers.task import Task
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.request.design import Design
from llsrbm.robots import Robot, RobotFile
from llsrbm.simulation.surroundings import Block


@dataclass(frozen=True, eq=False)
class Shown:
    """The motion that is shown.

    Attributes:
        planned: the plan, ready to be drawn.
        simulated: the simulation that followed it.
        so_far: frames of the simulation that is running.
        blocks: what stands around.
        source: where it is from, in words, if not from this tab's own planning.
    """

    planned: PlannedMotion
    simulated: SimulatedMotion | None = None
    so_far: Frames | None = None
    blocks: tuple[Block, ...] = ()
    source: str = ""

    @property
    def plan(self) -> Plan:
        """The plan."""
        return self.planned.plan

    @property
    def rollout(self) -> Rollout | None:
        """The simulation."""
        return None if self.simulated is None else self.simulated.rollout

    @property
    def solid(self) -> Frames | None:
        """Frames of the robot that follows the plan; None: the plan alone is shown."""
        return self.so_far if self.simulated is None else self.simulated.frames


@dataclass(frozen=True, eq=False)
class Known:
    """A motion that is there already: it is shown when its robot can be drawn, without planning.

    Attributes:
        plan: to show.
        rollout: that followed it.
        source: where both are from, in words; "": that goes without saying.
        note: on the file that holds them.
    """

    plan: Plan
    rollout: Rollout | None = None
    source: str = ""
    note: str = ""


@dataclass(frozen=True, eq=False)
class Work:
    """The tab's jobs on its motion: of the newest everything counts, of older ones only plans.

    Attributes:
        newest: ticket of the newest job.
        awaited: its task, until its outcome is there.
        shown: ticket of the job whose plan is shown.
        dropped: the job with this ticket and those before it are of no interest any more.
        failure: why the newest request cannot be planned.
        instead: that another jump type is planned than was asked for, and why; "": it is not so.
        nearest: a jump that can be planned, on offer in place of one that cannot.
        simulate_next: the plan that is awaited shall be simulated, with so many seeds (0: once).
        dragging: the request on its way.
        replay_from: s, from where the simulation that is awaited shall be played, as soon as there
            is something to see; None: where the page stands.
        compare: the change with which the design is simulated again once it has been simulated.
    """

    newest: int = 0
    awaited: Task | None = None
    shown: int = 0
    dropped: int = 0
    failure: str = ""
    instead: str = ""
    nearest: Nearest | None = None
    simulate_next: int | None = None
    dragging: DragPlanning = field(default_factory=DragPlanning)
    replay_from: float | None = None
    compare: Literal["replanning", "model"] | None = None


@dataclass(frozen=True, eq=False)
class FileWork:
    """Files that are being read and written, beside all else.

    Attributes:
        opening: ticket of the file that is being read; 0: none.
        opening_note: how that goes, once it takes its time.
        saving: ticket of the file that is being written; 0: none.
        saved: its formats; saving_note: how that goes.
    """

    opening: int = 0
    opening_note: str = ""
    saving: int = 0
    saved: str = ""
    saving_note: str = ""


@dataclass(frozen=True, eq=False)
class Seeds:
    """The same plan under several disturbances.

    Attributes:
        plan: that is followed.
        count: of the seeds that were asked for.
        results: of those that are done.
        worst: the rollout to look at first, when all are done.
    """

    plan: Plan
    count: int
    results: tuple[SeedResult, ...] = ()
    worst: Rollout | None = None


@dataclass(frozen=True)
class Playback:
    """How the motion is played, as the page reported last.

    Attributes:
        time: s.
        playing: whether it moves.
        speed: seconds of motion a second.
        loop: whether it starts again at the end.
    """

    time: float = 0.0
    playing: bool = False
    speed: float = 1.0
    loop: bool = True


@dataclass(frozen=True)
class View:
    """The overlays that are drawn, and in which light.

    Attributes:
        layers: names of overlays.
        night: a dark page.
        fine: with all triangles: the browser has a graphics processor.
    """

    layers: frozenset[str] = AT_FIRST
    night: bool = False
    fine: bool = False


@dataclass(frozen=True)
class History:
    """Designs to go back to, and forth again; the newest last.

    Attributes:
        back: before the present one; forth: that were gone back from.
        changing: names of the numbers that the last change changed; another change of the same
            ones belongs to it.
    """

    back: tuple[Design, ...] = ()
    forth: tuple[Design, ...] = ()
    changing: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class TabState:
    """Everything that is known of one tab.

    Attributes:
        robots: name -> file of each robot that can be chosen.
        design: what is asked for.
        robot: that is drawn; the design's, once it can be drawn.
        prepared: whether by its meshes; its collision shapes stand in for them until they are made.
        shown: the motion that is shown; None: there is none yet.
        known: the motion that is shown as soon as the robot is drawn.
        status: one line on how it goes.
        work, files, seeds: what is being computed.
        pins: what is compared; pin_chosen: number of the chosen one, -1: none.
        playback, view, plots: how it is shown; atlas: which map of which sweep.
        history: of the design.
        tickets: jobs so far; the next one gets the next number.
        note: on what was opened or chosen, beside the examples.
        csv_rate: whether a file came that does not say its frames per second.
        page: the page's scripts have answered.
    """

    robots: Mapping[str, RobotFile]
    design: Design
    robot: Robot | None = None
    prepared: bool = True
    shown: Shown | None = None
    known: Known | None = None
    status: Status = field(default_factory=lambda: Status(Word.PLANNING, ""))
    work: Work = field(default_factory=Work)
    files: FileWork = field(default_factory=FileWork)
    seeds: Seeds | None = None
    pins: tuple[Pin, ...] = ()
    pin_chosen: int = -1
    playback: Playback = field(default_factory=Playback)
    view: View = field(default_factory=View)
    plots: PlotChoice = DEFAULT
    atlas: AtlasChoice = field(default_factory=AtlasChoice)
    history: History = field(default_factory=History)
    tickets: int = 0
    note: str = ""
    csv_rate: bool = False
    page: bool = False

    @property
    def plan(self) -> Plan | None:
        """The plan that is shown."""
        return None if self.shown is None else self.shown.plan

    @property
    def rollout(self) -> Rollout | None:
        """The simulation of it that is shown."""
        return None if self.shown is None else self.shown.rollout

    @property
    def file(self) -> RobotFile:
        """Of the design's robot."""
        return self.robots[self.design.jump.robot]

    @property
    def ready(self) -> bool:
        """Whether the design's robot is drawn, so that its jumps can be planned and shown."""
        return self.robot is not None and self.robot.name == self.design.jump.robot

    @property
    def planning(self) -> bool:
        """Whether the plan that is shown is going to be replaced."""
        return isinstance(self.work.awaited, PlanJump) or self.work.dragging.rests
