"""The library as a computing process uses it: what reaches it, and what is left out."""

from dataclasses import replace

import pytest

import llsrbm
from app.workers.tasks import (
    CheckForeign,
    ExportMotion,
    FindLargest,
    OpenFile,
    PlanJump,
    RefinePlan,
    RepairMotion,
    SimulateJump,
)
from app.workers.worker import LibraryPlanner
from llsrbm.certified_plan import CertifiedPlanner
from llsrbm.errors import Cancelled, UnusableStart
from llsrbm.largest_jump import Largest
from llsrbm.ocp.horizon import Iterate
from llsrbm.planning.answer import planner as planner_module
from llsrbm.planning.solve.watch import PlanningProgress
from llsrbm.request.design import Design, dump_design
from llsrbm.request.jump import Jump
from llsrbm.request.route import Landing
from llsrbm.request.scenario import Scenario
from llsrbm.request.tuning import Tuning
from llsrbm.robots import load_robot
from tests.app.planners import turning_states
from tests.app.synthetic_plan import synthetic_plan
from tests.llsrbm.atlas.classifiers import learned_of

JUMP = Jump(twist=0.5)
TUNING = Tuning(weights={"force": 2.0}, limits={"friction": 0.4})


def silent(text, **details):
    pass


def never():
    return False


@pytest.fixture
def called(monkeypatch):
    """What the library's functions were called with."""
    calls = {}

    def record(name):
        def function(*arguments, **options):
            calls[name] = (arguments, options)
            return synthetic_plan(JUMP)

        return function

    for name in ("plan", "simulate"):
        monkeypatch.setattr(llsrbm, name, record(name))
    return calls


def planned(**changes):
    solved = replace(synthetic_plan(JUMP), solution=Iterate(None, None))
    return replace(solved, **changes)


ROUTE = JUMP.along(2 * (Landing(forward=0.2),))


def test_a_route_is_begun_from_a_table_and_drafted_where_that_has_none(monkeypatch, called):
    found, tasks = [synthetic_plan(ROUTE), None], []

    def from_table(planner, task):
        tasks.append(task)
        return found.pop(0)

    monkeypatch.setattr(CertifiedPlanner, "from_table", from_table)
    own = Tuning(limits={"friction": 0.4})
    planner, task = LibraryPlanner(), PlanJump(replace(ROUTE, payload=(2.0,)), own)
    assert planner.plan(task, silent, never).jump == ROUTE
    assert not called
    assert tasks[0].tuning == own
    assert tasks[0].mass == pytest.approx(load_robot("anymal").mass + 2.0)
    planner.plan(task, silent, never)
    assert called["plan"][1]["draft"]


def test_what_the_table_is_sure_of_is_by_the_whole_body_at_once_where_its_solver_is_there(
    monkeypatch, called
):
    certified, tasks = synthetic_plan(JUMP), []
    monkeypatch.setattr(
        CertifiedPlanner, "from_table", lambda _, task: tasks.append(task) or certified
    )
    planner, at_once = LibraryPlanner(), PlanJump(JUMP, patient=False, whole_body=True)
    with learned_of(load_robot("anymal")):
        planner.plan(at_once, silent, never)  # its solver is not there yet
        assert not tasks
        planner.refine(RefinePlan(planned(), JUMP), silent, never)
        called.clear()
        assert planner.plan(at_once, silent, never) is certified
        assert not called
        for other in (
            replace(at_once, whole_body=False),
            replace(at_once, jump=replace(JUMP, twist=3.0)),  # beyond what was ever planned
            replace(at_once, tuning=TUNING),
        ):
            planner.plan(other, silent, never)
            assert called.pop("plan")[1]["draft"]
    assert len(tasks) == 1


def test_a_search_gets_its_tuning_and_gives_the_largest_jump_alone(monkeypatch):
    calls, said = [], []
    plan = synthetic_plan(JUMP)

    def largest(*arguments, progress, **options):
        calls.append((arguments, options))
        progress(PlanningProgress("0.65 m holds, trying 0.70 m"))
        return Largest("up", 0.7, "m", "a knee", plan, (plan, plan))

    monkeypatch.setattr(llsrbm, "largest", largest)
    task = FindLargest(JUMP, TUNING, "up")
    found = LibraryPlanner().largest(task, lambda text, **_: said.append(text), never)
    assert (found.plan, found.smaller) == (plan, ())
    ((arguments, options),) = calls
    assert arguments == (JUMP, "up")
    assert (options["weights"], options["limits"]) == (TUNING.weights, TUNING.limits)
    assert options["cancelled"] is never
    assert said[0].startswith("building the whole-body solver of ANYmal")
    assert said[1:] == ["0.65 m holds, trying 0.70 m"]


def test_a_plan_gets_its_tuning_and_the_plan_to_start_from(called):
    near = planned()
    LibraryPlanner().plan(PlanJump(JUMP, TUNING, near, patient=False), silent, never)
    (jump,), options = called["plan"]
    assert jump == JUMP
    assert (options["weights"], options["limits"]) == (TUNING.weights, TUNING.limits)
    assert options["near"] is near
    assert options["hurried"] is True
    assert options["cancelled"] is never


@pytest.mark.parametrize(
    "changes",
    [
        {"solution": None},
        {"jump": replace(JUMP, model="srbm")},
        {"jump": replace(JUMP, robot="go2")},
    ],
)
def test_what_is_of_no_use_to_start_from_is_left_out(called, changes):
    LibraryPlanner().plan(PlanJump(JUMP, near=planned(**changes)), silent, never)
    assert called["plan"][1]["near"] is None


def test_a_plan_that_the_planner_cannot_start_from_is_left_out(monkeypatch):
    """From a file of another version, or made up: only the planner can tell."""
    asked = []

    def plan(jump, *, near, **_):
        asked.append(near)
        if near is not None:
            raise UnusableStart("near: the plan is of another version of the planner")
        return synthetic_plan(jump)

    monkeypatch.setattr(llsrbm, "plan", plan)
    near = planned()
    assert LibraryPlanner().plan(PlanJump(JUMP, near=near), silent, never).jump == JUMP
    assert asked == [near, None]


def test_a_file_is_opened_and_its_robot_prepared(monkeypatch):
    prepared = []
    monkeypatch.setattr(
        LibraryPlanner, "prepare", lambda _, robot, progress: prepared.append(robot)
    )
    design = dump_design(Design(Jump(robot="go2")))
    task = OpenFile("mine.jump.json", design.encode(), "anymal")
    assert LibraryPlanner().open(task, silent).holds.jump.robot == "go2"
    assert prepared == ["go2"]


def test_an_export_is_one_file_whatever_it_is_of():
    task = ExportMotion(synthetic_plan(JUMP), ("csv",), options={"fps": 10.0})
    name, table = LibraryPlanner().export(task, silent)
    assert name == "anymal_twist29.csv"
    assert table.startswith(b"time [s]")
    name, folder = LibraryPlanner().export(ExportMotion(synthetic_plan(JUMP), ("mujoco",)), silent)
    assert name == "anymal_twist29_mujoco.zip"
    assert folder.startswith(b"PK")


def test_a_simulation_gets_its_scenario_and_reports_whole_per_cents_and_the_motion(called):
    reported, motions = [], []

    def progress(text, *, share):
        reported.append((text, share))

    def so_far(*motion):
        motions.append(motion)

    scenario = Scenario(0.02, True, 3, 0.5, "norm", "planned", "quadprog", 0.12)
    LibraryPlanner().simulate(SimulateJump(planned(), scenario), progress, so_far, never)
    (_, given), options = called["simulate"]
    assert given == scenario
    for k in range(1001):
        options["progress"](k / 1000)
        if k == 500:
            options["so_far"]("times", "states")
    assert len(reported) == 101
    assert reported[50] == ("simulating, 50 %", 0.5)
    assert motions == [(0.5, "times", "states")]


@pytest.mark.parametrize(
    ("built", "announced"),
    [
        (True, "loading the solver for ANYmal B by LL-SRBM+"),
        (False, "building the solver for ANYmal B by LL-SRBM+: ten seconds, the first time"),
    ],
)
def test_the_solver_is_announced_once_a_process(called, monkeypatch, built, announced):
    monkeypatch.setattr(planner_module, "is_planner_built", lambda *_: built)
    told = []
    planner = LibraryPlanner()
    for _ in range(2):
        planner.plan(PlanJump(JUMP), lambda text, lasts: told.append((text, lasts > 0)), never)
    assert told == [(announced, True)]


def test_solvers_that_plan_anew_are_announced_where_they_are_needed(called):
    told = []
    planner = LibraryPlanner()
    for replan in (False, True, True):
        task = SimulateJump(planned(), Scenario(replan=replan))
        planner.simulate(task, lambda text, **_: told.append(text), lambda *_: None, never)
    (line,) = told
    assert line.startswith("building the solvers that plan anew, for ANYmal B by LL-SRBM+")


# ---- motions of other tools


def test_another_tools_motion_is_checked_as_by_the_command():
    states, said = turning_states("go2"), []
    found = LibraryPlanner().check(CheckForeign(states), said.append)
    assert found == llsrbm.certify(states.motion())
    assert said == ["checking the motion at 1 kHz"]


def test_a_repair_without_a_flight_is_an_answer_and_says_why():
    states = turning_states("go2", seconds=0.4)  # it stands
    found = LibraryPlanner().repair(RepairMotion(states), silent, never)
    assert (found.status, found.plan) == ("failed", None)
    assert found.why == "No foot leaves the ground for a flight of all feet."
    assert found.before == llsrbm.certify(states.motion())


def test_a_repair_is_cancelled():
    with pytest.raises(Cancelled):
        LibraryPlanner().repair(RepairMotion(turning_states("go2")), silent, lambda: True)
