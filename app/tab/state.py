"""Everything that is known of one tab, as a value: `TabState`.

Nothing else holds a fact about a tab. Events change it (`app.tab.acts`), the picture, the
panel and the plots are drawn from it (`app.tab.rendering`), and it stays for some minutes when a
connection ends (`app.tab.tabs`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from app.motion import colours
from app.motion.baked import ForeignMotion, PlannedMotion, SimulatedMotion
from app.motion.colours import Rgb
from app.panel.atlas_controls import AtlasChoice
from app.panel.file_controls import FileChoice
from app.panel.route_controls import ChosenLanding
from app.panel.status import SeedResult, Status, Verdict
from app.panel.view_controls import View
from app.picture.picture import Ghost
from app.plots.choice import DEFAULT, PlotChoice, of_jump
from app.tab.contenders import Comparing
from app.tab.foreign import Foreign
from app.tab.how_far import HowFar
from app.tab.planning.dragging import DragPlanning
from app.tab.shown import Given, Shown
from app.tab.slider_ends import Beyond, reaching, stretched
from app.workers.tasks import PlanJump, RefinePlan, RepairMotion, SimulateJump, Task
from llsrbm.analysis.figures import DesignFigures, figures_of_plan
from llsrbm.certificate import Certificate
from llsrbm.look.titles import Decisions, decisions_of
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.planning.whole_body.feasible import Feasible
from llsrbm.request.design import Design
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Push, Scenario
from llsrbm.request.tuning import Tuning
from llsrbm.robots import Robot, RobotFile
from llsrbm.robots.schema import Task as Ends

QUICK = 2.0
"""s; a simulation that takes no longer is begun after every change, unless that is switched off."""


@dataclass(frozen=True, eq=False)
class Pin:
    """One design with its motion, or a motion from a file."""

    motion: PlannedMotion | ForeignMotion  # its plan, or what a file holds
    simulated: SimulatedMotion | None  # the simulation that followed the plan, if there was one
    design: Design | None  # what was asked for; None where that is not known
    colour: Rgb  # of its ghost and curves

    @property
    def rollout(self) -> Rollout | None:
        """The simulation."""
        return None if self.simulated is None else self.simulated.rollout

    @cached_property
    def ghost(self) -> Ghost:
        """The robot that is drawn of it, the simulated one if there is one."""
        frames = self.motion.frames if self.simulated is None else self.simulated.frames
        return Ghost(self.motion.motion.robot, frames, self.colour)

    @cached_property
    def figures(self) -> DesignFigures:
        """Its row of numbers."""
        if isinstance(self.motion, ForeignMotion):
            return self.motion.figures
        return figures_of_plan(self.motion.plan, self.rollout)

    @property
    def decisions(self) -> Decisions | None:
        """Which its title is made from; None of a motion that has its file's name."""
        if isinstance(self.motion, ForeignMotion):
            return None
        return decisions_of(self.rollout or self.motion.plan)


def free_colour(pins: tuple[Pin, ...]) -> Rgb | None:
    """A colour that none of the pins has; None: all are taken, and no more can be pinned."""
    taken = {pin.colour for pin in pins}
    return next((colour for colour in colours.PINNED if colour not in taken), None)


@dataclass(frozen=True, eq=False)
class Work:
    """The tab's jobs on its motion: of the newest everything counts, of older ones only plans."""

    newest: int = 0  # ticket of the newest job
    awaited: Task | None = None  # its task, until its outcome is there
    shown: int = 0  # ticket of the job whose plan is shown
    dropped: int = 0  # the job with this ticket and those before it are of no interest any more
    instead: str = ""  # the sentence that says that another jump type is planned; "": none is
    # the plan that is awaited shall be simulated, with so many seeds (0: once)
    simulate_next: int | None = None
    dragging: DragPlanning = field(default_factory=DragPlanning)  # the request on its way
    # s, from where the simulation that is awaited shall be played, as soon as there is something to
    # see; None: where the page stands
    replay_from: float | None = None


@dataclass(frozen=True, eq=False)
class FileWork:
    """Files that are being read and written, beside all else."""

    opening: int = 0  # ticket of the file that is being read; 0: none
    opening_note: str = ""  # on its progress, once it takes its time
    saving: int = 0  # ticket of the file that is being written; 0: none
    saved: str = ""  # its formats
    saving_note: str = ""  # on its progress


@dataclass(frozen=True, eq=False)
class Check:
    """The certificate of a motion, as far as it is there."""

    motion: Plan | Rollout  # that is checked
    ticket: int = 0  # of the job that makes it; 0: none is under way
    certificate: Certificate | None = None
    note: str = ""  # on its progress, or why there is none


@dataclass(frozen=True, eq=False)
class Seeds:
    """The same plan under several disturbances."""

    plan: Plan  # that is followed
    scenario: Scenario  # of the design, when they were begun
    count: int  # of the seeds
    results: tuple[SeedResult, ...] = ()  # of those that are done
    worst: Rollout | None = None  # the rollout to look at first, when all are done


@dataclass(frozen=True)
class Playback:
    """How the motion is played, as the page reported last."""

    time: float = 0.0  # s
    playing: bool = False  # whether it moves
    speed: float = 1.0  # seconds of motion a second
    loop: bool = True  # whether it starts again at the end


@dataclass(frozen=True)
class History:
    """Designs to go back to, and forth again; the newest last."""

    back: tuple[Design, ...] = ()  # before the present one
    forth: tuple[Design, ...] = ()  # that were gone back from
    # names of the numbers that the last change changed; another change of the same ones belongs to
    # it
    changing: tuple[str, ...] = ()
    # field of the request that was dragged last in the picture, and the number of that grip
    grip: tuple[str, int] = ("", 0)


@dataclass(frozen=True, eq=False)
class TabState:
    """Everything that is known of one tab."""

    robots: Mapping[str, RobotFile]  # name -> file of each robot that can be chosen
    design: Design  # of the visitor
    robot: Robot | None = None  # that is drawn; the design's, once it can be drawn
    # whether by its meshes; its collision shapes stand in for them until they are made
    prepared: bool = True
    shown: Shown | None = None  # the motion that is shown; None: there is none yet
    given: Given | None = None  # the motion that is shown as soon as the robot is drawn
    # one line on the progress
    status: Status = field(default_factory=lambda: Status(Verdict.PLANNING, busy=True))
    work: Work = field(default_factory=Work)  # work, files, seeds: what is being computed
    files: FileWork = field(default_factory=FileWork)
    seeds: Seeds | None = None
    check: Check | None = None  # of the motion that was shown when it was asked for
    pins: tuple[Pin, ...] = ()  # what is compared
    pin_chosen: int = -1  # number of the chosen one, -1: none
    # another tool's motion, one of the pins, that was opened last; None: none is open
    foreign: Foreign | None = None
    beside: bool = False  # their robots stand beside the one that is shown, else where they are
    # the jump made in several ways, in place of the motion that is shown; None: it is not compared
    comparing: Comparing | None = None
    # how far the robot jumps in one direction, as far as it is known; None: nobody has asked
    far: HowFar | None = None
    # robot name -> what was asked for, or found, beyond the usual requests of its file
    reach: Mapping[str, Beyond] = field(default_factory=dict)
    playback: Playback = field(default_factory=Playback)  # playback, view, plots: how it is shown
    view: View = field(default_factory=View)
    dark: bool = False  # the visitor's system is
    fine: bool = False  # with all triangles, as the browser has a graphics processor
    plots: PlotChoice = DEFAULT
    # robot name -> which of its jumps can be planned, as far as this tab has found out
    feasible: Mapping[str, Feasible] = field(default_factory=dict)
    atlas: AtlasChoice = field(default_factory=AtlasChoice)  # which map of which sweep
    export: FileChoice = field(default_factory=FileChoice)  # in which formats
    noise: float | None = None  # of the scenario when it was last disturbed
    whole_body: bool = True  # whether drafts are replaced by plans of the whole body's dynamics
    # whether what changes is simulated again by itself; None: where that is quick
    automatically: bool | None = None
    simulated_in: float | None = None  # s that the last simulation took; None: there was none
    history: History = field(default_factory=History)  # of the design
    # motions of designs before the present one, by what was asked for; the newest last
    answers: tuple[tuple[tuple[Jump, Tuning], Shown], ...] = ()
    tickets: int = 0  # jobs so far; the next one gets the next number
    note: str = ""  # on what was opened or chosen, beside the examples
    page: bool = False  # the page's scripts have answered
    # the request as it was when its route began to be drawn by clicks; None: none is drawn
    drawing: Jump | None = None
    landing: int = 0  # number of the one of a route whose numbers are shown

    @property
    def seen(self) -> Shown | None:
        """The motion in the picture: the one that is shown, or one of those that are compared."""
        compared = None if self.comparing is None else self.comparing.last
        return self.shown if compared is None else compared.shown

    @property
    def plots_seen(self) -> PlotChoice:
        """The charts of the motion in the picture; an overview is that of its jump."""
        comparing = self.comparing
        if comparing is not None and comparing.last is not None:
            return comparing.plots
        return of_jump(self.plots, self.design.jump if self.plan is None else self.plan.jump)

    @property
    def plan(self) -> Plan | None:
        """The plan that is shown."""
        return None if self.shown is None else self.shown.plan

    @property
    def rollout(self) -> Rollout | None:
        """The simulation of it that is shown."""
        return None if self.shown is None else self.shown.rollout

    @property
    def motion(self) -> Plan | Rollout | None:
        """The simulation that is shown, else the plan."""
        return self.plan if self.rollout is None else self.rollout

    @property
    def pushes(self) -> tuple[Push, ...]:
        """Pushes of the simulation that is shown."""
        task = self.work.awaited
        if self.shown is not None and self.shown.so_far and isinstance(task, SimulateJump):
            return task.scenario.pushes
        return () if self.rollout is None else self.rollout.pushes

    @property
    def file(self) -> RobotFile:
        """File of the design's robot, as it applies to the design's jump."""
        jump = self.design.jump
        return self.robots[jump.robot].for_jump(turns=jump.turns)

    @property
    def file_choice(self) -> FileChoice:
        """The options of an export, with a choice of motions if there are two, and the robot."""
        robot = self.robot if self.ready else None
        return replace(self.export, simulated=self.rollout is not None, robot=robot)

    @property
    def ends(self) -> Ends:
        """Ends of the sliders: the usual ones, and whatever beyond was asked for or found."""
        return stretched(self.file.task, self.reach.get(self.design.jump.robot, {}))

    @property
    def chosen_landing(self) -> ChosenLanding:
        """The landing of the design's route whose numbers are shown."""
        return ChosenLanding.of(self.design.jump, self.landing)

    @property
    def ready(self) -> bool:
        """Whether the design's robot is drawn, so that its jumps can be planned and shown."""
        return self.robot is not None and self.robot.name == self.design.jump.robot

    @property
    def planning(self) -> bool:
        """Whether the plan that is shown is going to be replaced."""
        makes_plan = isinstance(self.work.awaited, PlanJump | RefinePlan)
        return makes_plan or self.work.dragging.rests

    @property
    def repairing(self) -> bool:
        """Whether a motion is being repaired."""
        return isinstance(self.work.awaited, RepairMotion)

    @property
    def moving(self) -> bool:
        """Whether that is soon, as a control may be moving still."""
        task = self.work.awaited
        return self.work.dragging.rests or (isinstance(task, PlanJump) and not task.patient)

    @property
    def outdated(self) -> bool:
        """Whether the simulation that is shown was asked for in another scenario."""
        shown = self.shown
        return shown is not None and shown.scenario not in (None, self.design.scenario)

    @property
    def automatic(self) -> bool:
        """Whether what changes is simulated again by itself."""
        if self.automatically is None:
            return self.simulated_in is not None and self.simulated_in <= QUICK
        return self.automatically

    @property
    def remark(self) -> str:
        """In which way the motion that is shown is not what is asked for; "" if it is."""
        if self.outdated:
            return "Simulated with another scenario"
        return "" if self.shown is None else self.shown.remark

    def with_work(self, **changes: Any) -> TabState:
        """With other values of `Work`."""
        return replace(self, work=replace(self.work, **changes))

    def with_files(self, **changes: Any) -> TabState:
        """With other values of `FileWork`."""
        return replace(self, files=replace(self.files, **changes))

    def with_status(
        self,
        verdict: Verdict,
        rest: str,
        *,
        busy: bool = False,
        share: float | None = None,
        lasts: float | None = None,
    ) -> TabState:
        """With another status line; the figures of the motion before stay while one is awaited."""
        status = Status(verdict, rest, busy, share, lasts=lasts)
        if busy and self.shown is not None:
            before = self.status
            old = verdict is Verdict.PLANNING or before.old
            old |= before.verdict in (Verdict.LANDED, Verdict.FELL)
            status = replace(status, figures=before.figures, old=old)
        return replace(self, status=status)

    def reaching(self, jump: Jump) -> TabState:
        """With sliders of its robot that reach to a jump."""
        usual = self.robots[jump.robot].for_jump(turns=jump.turns).task
        before = self.reach.get(jump.robot, {})
        beyond = reaching(before, usual, jump)
        if beyond == before:
            return self
        return replace(self, reach={**self.reach, jump.robot: beyond})

    def forgetting(self) -> TabState:
        """With no request on its way: the same one counts as a new one."""
        return self.with_work(dragging=self.work.dragging.forget())

    def without_sequel(self) -> TabState:
        """With nothing to follow the plan or the simulation that is awaited."""
        return self.with_work(simulate_next=None, replay_from=None)
