"""`update` with any events in any order."""

from dataclasses import fields, is_dataclass, replace
from functools import cache

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from app import link
from app.link import ComparisonClosed, ExportChosen, PageReady, PlayerMoved, PushDragged
from app.motion.colours import PINNED
from app.panel.acts import Act
from app.panel.file_controls import FileChoice
from app.panel.status import SeedResult
from app.tab.acts import Corrected, update
from app.tab.comparison import PinChosen
from app.tab.effects import (
    After,
    Effect,
    Forget,
    LoadRobot,
    Reported,
    RobotLoaded,
    RobotMissing,
    Stop,
    Submit,
)
from app.tab.files import FileChosen
from app.tab.planning.refining import WholeBody
from app.tab.planning.requests import Rested
from app.tab.start.opening import TabOpened, first_state, left, resume
from app.workers.opened_file import OpenedFile
from app.workers.reports import (
    Cancelled,
    Checked,
    Exported,
    Failed,
    FoundLargest,
    Opened,
    Planned,
    Prepared,
    Progress,
    Refused,
    Repaired,
    SeedDone,
    Simulated,
    SimulatedSeeds,
    SimulatedSoFar,
)
from app.workers.tasks import (
    CheckMotion,
    ExportMotion,
    FindLargest,
    FollowWay,
    OpenFile,
    OpenMotion,
    PlanJump,
    Prepare,
    RefinePlan,
    RepairMotion,
    SimulateJump,
    SimulateSeeds,
)
from llsrbm.largest_jump import DIRECTIONS, Largest
from llsrbm.request.design import Design
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Push, Scenario
from llsrbm.request.tuning import Tuning
from llsrbm.robots import load_robot
from tests.app.planners import CERTIFICATE, repair_of, turning_states
from tests.app.pure_tab import ROBOTS, plan_of, rollout_of
from tests.app.synthetic_plan import refined_plan

JUMPS = [
    Jump(robot=robot, twist=twist, forward=forward)
    for robot in ("anymal", "go2")
    for twist, forward in ((1.0, 0.0), (1.0, 0.1), (0.3, 0.1))
]
TUNINGS = [Tuning(), Tuning(limits={"friction": 0.4})]
SCENARIOS = [
    Scenario(),
    Scenario(board=0.02, seed=3),
    Scenario(pushes=(Push(0.5, (0.0, 9.0, 0.0)),), replan=True),
]
DESIGNS = st.builds(
    Design, *map(st.sampled_from, (JUMPS, TUNINGS, SCENARIOS)), st.sampled_from(["", "On ice"])
)
FILES = st.sampled_from(
    [
        Design(JUMPS[1], title="From a file"),
        plan_of(JUMPS[2]),
        plan_of(JUMPS[4], "not-converged"),
        rollout_of(plan_of(JUMPS[0])),
        turning_states("go2"),
    ]
).map(lambda holds: OpenedFile("file", holds))

WISHES = st.one_of(
    st.sampled_from(
        [
            Act.SIMULATE,
            Act.SEEDS,
            Act.CHECK,
            Act.ROBOT_SIMULATOR,
            Act.COMPARE_REPLANNING,
            Act.COMPARE_MODELS,
            Act.COMPARE_ARMS,
            Act.COMPARE_DRIVES,
            ComparisonClosed(),
            link.RepairAsked(),
            Act.FAR_TWIST,
            Act.FAR_FORWARD,
            Act.USE_LARGEST,
            PushDragged(0.4, 0.3, 0.0, ended=False),
            PushDragged(0.4, 0.3, -0.1, ended=True),
            Act.WORST,
            Act.CANCEL,
            Act.NEAREST,
            Act.UNDO,
            Act.REDO,
            Act.PIN,
            Act.UNPIN,
            Act.USE_PINNED,
            Act.SAVE,
            Act.SHARE,
            Act.CHOOSE_EXPORT,
            ExportChosen("csv"),
            Act.STOP_FILES,
            WholeBody(True),
            WholeBody(False),
            FileChosen("a.csv", b""),
            PageReady(software=True),
            PlayerMoved(0.3, playing=True),
            PlayerMoved(0.6, playing=False),
        ]
    ),
    DESIGNS.map(lambda d: Corrected(d.jump, ("corrected",)) if d.title else d.jump),
    st.sampled_from((*SCENARIOS, *TUNINGS)),
    DESIGNS,
    st.integers(-1, 4).map(PinChosen),
    st.sampled_from([Act.EXPORT, FileChoice("npz", of="plan"), FileChoice("csv", ("npz",))]),
)


@cache
def simulated(plan, scenario):
    return replace(rollout_of(plan_of(plan.jump)), plan=plan, scenario=scenario)


SEED = SeedResult(0, True, True, None, 0.01, "landed")


def partial_report(task):
    match task:
        case SimulateJump(plan=plan):
            run = rollout_of(plan_of(plan.jump))
            return SimulatedSoFar(0, 0.1, run.time[:60:20], run.qpos[:60:20])
        case SimulateSeeds(seeds=seeds):
            return SeedDone(0, SEED, 1, len(seeds))
    return Progress(0, "working")


def success(task, file):
    match task:
        case Prepare(robot):
            return Prepared(0, robot)
        case PlanJump(jump, tuning):
            return Planned(0, _plan(jump, tuning))
        case RefinePlan(plan=plan):
            return Planned(0, refined_plan(plan))
        case SimulateJump(plan=plan, scenario=scenario) | FollowWay(plan=plan, scenario=scenario):
            return Simulated(0, simulated(plan, scenario))
        case SimulateSeeds(plan=plan, seeds=seeds, scenario=scenario):
            return SimulatedSeeds(0, (SEED,) * len(seeds), simulated(plan, scenario))
        case OpenFile() | OpenMotion():
            return Opened(0, file)
        case ExportMotion():
            return Exported(0, "a.npz", b"1")
        case CheckMotion():
            return Checked(0, CERTIFICATE)
        case RepairMotion(motion=motion):
            return Repaired(0, repair_of(motion))
        case FindLargest(jump=jump, towards=towards):
            return FoundLargest(0, largest(jump, towards))


@cache
def largest(jump, towards):
    direction = DIRECTIONS[towards]
    plan = refined_plan(plan_of(direction.of(jump, 80)))
    return Largest(towards, direction.value(80), direction.unit, "a knee stops it", plan)


@cache
def _plan(jump, tuning):
    return replace(plan_of(jump), tuning=tuning)


def parts(value):
    """(place, identity) of everything that a state is made of."""
    found, left_over = [], [("", value)]
    while left_over:
        place, part = left_over.pop()
        found.append((place, part))
        if is_dataclass(part) and type(part).__module__.startswith("app.tab"):
            left_over += [(f"{place}.{f.name}", getattr(part, f.name)) for f in fields(part)]
    return found


class AnyEvents(RuleBasedStateMachine):
    """A visitor, a pool and a loader of robots that do their worst."""

    @initialize(known=st.booleans(), kept=st.none() | DESIGNS, file=st.none() | FILES)
    def open(self, known, kept, file):
        self.running = []  # Submits without an outcome
        self.loading = []  # names of robots
        self.due = None
        self.tickets = set()
        self.state = first_state(ROBOTS)
        plan = plan_of(self.state.design.jump) if known else None
        self.take(TabOpened(kept, plan, file))

    def take(self, event):
        before = parts(self.state)
        state, effects = update(self.state, event)
        assert all(one is other for (_, one), (_, other) in zip(before, parts(self.state)))
        self.go_on(state, effects)

    def go_on(self, state, effects):
        assert state.tickets >= self.state.tickets
        self.state = state
        stopped = []
        for effect in effects:
            assert isinstance(effect, Effect)
            match effect:
                case Submit(ticket=ticket):
                    assert ticket not in self.tickets
                    assert ticket <= state.tickets
                    self.tickets.add(ticket)
                    self.running.append(effect)
                case Stop(queue):
                    stopped += [submit for submit in self.running if submit.queue is queue]
                case Forget(queue):
                    self.running = [each for each in self.running if each.queue is not queue]
                case LoadRobot(name):
                    self.loading.append(name)
                case After(event=event):
                    self.due = event
        for submit in stopped:
            self.running.remove(submit)
            self.take(Reported(submit, Cancelled(0)))

    @rule(event=WISHES)
    def wish(self, event):
        self.take(event)

    @rule(jump=st.sampled_from(JUMPS), tuning=st.sampled_from(TUNINGS))
    def move(self, jump, tuning):
        self.take(tuning)
        self.take(jump)

    @precondition(lambda self: self.state.history.back)
    @rule()
    def undo(self):
        self.take(Act.UNDO)

    @precondition(lambda self: self.running)
    @rule(file=FILES)
    def finish_newest(self, file):
        submit = self.running.pop()
        self.take(Reported(submit, success(submit.task, file)))

    @precondition(lambda self: self.running)
    @rule(data=st.data(), file=FILES, end=st.sampled_from(["success", "partial", "failure"]))
    def report(self, data, file, end):
        submit = data.draw(st.sampled_from(self.running))
        if end == "partial":
            report = partial_report(submit.task)
        else:
            self.running.remove(submit)
            report = success(submit.task, file) if end == "success" else self.failure(submit)
        newest = submit.ticket in (
            self.state.work.newest,
            self.state.files.opening,
            self.state.files.saving,
            self.state.check and self.state.check.ticket,
            self.state.far and self.state.far.ticket,
            self.state.foreign and self.state.foreign.ticket,
            *(
                each.ticket
                for comparing in [self.state.comparing]
                if comparing
                for each in comparing.contenders
            ),
        )
        before = self.state
        self.take(Reported(submit, report))
        if not newest and not isinstance(report, Planned | Refused):
            assert self.state is before

    def failure(self, submit):
        if not isinstance(submit.task, PlanJump):
            return Failed(0, "no")
        jump = submit.task.jump
        nearest = None if jump.forward else _plan(replace(jump, twist=0.5), submit.task.tuning)
        return Refused(0, jump, "no", plan_of(jump, "not-converged"), nearest)

    @precondition(lambda self: self.loading)
    @rule(missing=st.sampled_from([False, False, False, True]))
    def load(self, missing):
        name = self.loading.pop(0)
        gone = RobotMissing(name, "no meshes")
        self.take(gone if missing else RobotLoaded(load_robot(name)))

    @precondition(lambda self: self.due)
    @rule()
    def rest(self):
        event, self.due = self.due, None
        self.take(event)

    @rule(time=st.sampled_from([0.0, 0.4]))
    def come_back(self, time):
        self.running, self.loading, self.due = [], [], None
        self.go_on(*resume(left(self.state), PageReady(software=True, time=time)))

    # ---- what always holds

    @invariant()
    def what_is_shown_is_of_the_robot_that_is_drawn(self):
        state = self.state
        if state.shown is not None:
            assert state.robot is not None
            assert state.plan.jump.robot == state.robot.name
            assert state.rollout is None or state.rollout.plan is state.plan

    @invariant()
    def a_page_that_is_busy_waits_for_something(self):
        state = self.state
        waits = (
            any(submit.ticket == state.work.newest for submit in self.running),
            bool(self.loading),
            self.due == Rested(state.work.dragging.rest) and state.work.dragging.rests,
        )
        if state.status.busy or state.planning:
            assert any(waits)
        if state.check is not None and state.check.ticket:
            assert any(submit.ticket == state.check.ticket for submit in self.running)
        if state.far is not None and state.far.running:
            assert any(submit.ticket == state.far.ticket for submit in self.running)
            assert state.far.is_of(state.design)
        if state.foreign is not None:
            assert any(pin.motion is state.foreign.motion for pin in state.pins)
            if state.foreign.ticket:
                assert any(submit.ticket == state.foreign.ticket for submit in self.running)
        if state.check is not None and state.check.certificate is None:
            assert state.check.ticket or state.check.note.startswith("Not checked")
        if state.files.opening or state.files.saving:
            assert {state.files.opening, state.files.saving} & {s.ticket for s in self.running}

    @invariant()
    def a_robot_that_is_asked_for_is_on_its_way(self):
        state = self.state
        if not state.ready and state.status.busy:
            name = state.design.jump.robot
            assert state.work.awaited == Prepare(name) or name in self.loading

    @invariant()
    def what_is_awaited_will_be_reported(self):
        if self.state.work.awaited is not None:
            assert any(submit.task is self.state.work.awaited for submit in self.running)

    @invariant()
    def pins_differ_in_colour(self):
        pins = self.state.pins
        assert len({pin.colour for pin in pins}) == len(pins) <= len(PINNED)
        assert -1 <= self.state.pin_chosen < len(pins)

    @invariant()
    def redo_restores_what_undo_took(self):
        state = self.state
        if state.history.back:
            gone, _ = update(state, Act.UNDO)
            assert gone.design == state.history.back[-1]
            again, _ = update(gone, Act.REDO)
            assert again.design == state.design
            assert again.history.back == state.history.back


TestAnyEvents = AnyEvents.TestCase
TestAnyEvents.settings = settings(
    max_examples=50,
    stateful_step_count=30,
    deadline=None,
    suppress_health_check=list(HealthCheck),
)
