"""Files opened and saved, as values."""

from dataclasses import replace

import pytest

from app.link import ExportChosen
from app.motion.colours import PINNED
from app.panel.acts import Act
from app.panel.file_controls import PLAN, FileChoice, _hindrance
from app.panel.status import Verdict
from app.tab.acts import is_enabled
from app.tab.effects import (
    Download,
    Keep,
    LoadRobot,
    Notify,
    Queue,
    RobotLoaded,
    ShowExports,
    Stop,
)
from app.tab.files import FileChosen
from app.workers.opened_file import OpenedFile
from app.workers.reports import Cancelled, Exported, Failed, Opened, Progress
from app.workers.tasks import OpenFile
from llsrbm.formats import FORMATS
from llsrbm.request.design import Design, load_design
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from llsrbm.request.tuning import Tuning
from llsrbm.robots import load_robot
from tests.app.planners import turning_states
from tests.app.pure_tab import PureTab, plan_of, planned_tab, rollout_of

JUMP = Jump(model="srbm", twist=1.234, forward=0.123)
SCENARIO = Scenario(board=0.02, seed=7, noise=2.0)


@pytest.fixture
def tab():
    return planned_tab()


@pytest.fixture(scope="module")
def states():
    return turning_states("anymal")


def rollout(jump=JUMP, **changes):
    return replace(rollout_of(plan_of(jump)), scenario=SCENARIO, **changes)


def opened(tab, holds, name="mine.npz", *remarks):
    tab.take(FileChosen(name, b"content"))
    return tab.report(Opened(0, OpenedFile(name, holds, remarks)))


# ---- opening


@pytest.mark.parametrize(("name", "rate"), [("a.npz", None), ("a.CSV", 25.0)])
def test_a_file_is_read_in_a_lane_of_its_own(tab, name, rate):
    tab.move(forward=0.1)
    tab.take(FileChoice(rate=25.0))
    tab.take(FileChosen(name, b"content"))
    assert tab.one.queue is Queue.OPEN
    task = tab.task
    assert isinstance(task, OpenFile)
    assert (task.name, task.content, task.robot, task.fps) == (name, b"content", "anymal", rate)
    assert tab.state.export.rate_needed == (rate is not None)
    assert tab.state.planning


def test_of_two_files_the_newer_one_counts(tab):
    tab.take(FileChosen("a.npz", b""))
    older = tab.submits[-1]
    tab.take(FileChosen("b.npz", b""))
    before = tab.state
    tab.report(Opened(0, OpenedFile("a.npz", plan_of(JUMP))), submit=older)
    assert tab.state is before
    tab.report(Opened(0, OpenedFile("b.npz", plan_of(JUMP))))
    assert tab.told[1].startswith("from file b.npz")


def test_only_waiting_is_told(tab):
    tab.take(FileChosen("a.npz", b""))
    tab.report(Progress(0, "waiting: two others", waiting=True))
    assert tab.state.files.opening_note == "waiting: two others"
    tab.report(Failed(0, "a.npz: no"))
    assert tab.state.files.opening_note == ""
    assert tab.notes() == [("Not opened", "a.npz: no")]
    assert tab.state.note == ""  # it is said once


def test_a_plan_is_shown_without_planning(tab):
    plan = plan_of(JUMP)
    before = tab.state.design
    opened(tab, plan, "mine.npz", "It is old.")
    assert tab.one == Keep(tab.state.design)
    assert tab.state.plan is plan
    assert tab.state.design == Design(JUMP)
    assert tab.state.note == "Opened mine.npz. It is old."
    assert tab.told[0] is Verdict.DRAFT
    assert tab.told[1] == "from file mine.npz, as its drives were looked at in knots only"
    assert tab.state.status.figures[1] == ("Flight time", "0.500 s")
    assert tab.move() == ()  # it counts as planned
    tab.move(forward=0.13)
    assert tab.task.near is plan
    assert tab.state.note == ""
    tab.take(Act.UNDO)
    tab.take(Act.UNDO)
    assert tab.state.design == before


def test_a_file_ends_what_is_being_planned(tab):
    tab.move(forward=0.1)
    running = tab.submits[-1]
    opened(tab, plan_of(JUMP))
    assert not tab.state.status.busy
    before = tab.state
    assert tab.finish_plan(running) == ()
    assert tab.report(Cancelled(0), submit=running) == ()
    assert tab.state is before


def test_one_that_did_not_converge_says_so(tab):
    opened(tab, plan_of(JUMP, "not-converged"), "bad.npz")
    assert tab.told[0] is Verdict.FAILED
    assert tab.told[1].startswith("from file bad.npz: the planner did not converge")


def test_a_simulation_is_shown_with_its_plan_and_scenario(tab):
    run = rollout()
    opened(tab, run, "run.npz")
    assert (tab.state.plan, tab.state.rollout) == (run.plan, run)
    assert tab.state.design == Design(JUMP, Tuning(), SCENARIO)
    assert tab.told[0] is Verdict.LANDED
    assert tab.told[1] == "from file run.npz"
    tab.take(Act.SIMULATE)
    assert tab.submits[-1].task.scenario == SCENARIO


def test_another_robots_plan_waits_for_its_robot(tab):
    plan = plan_of(Jump(robot="slider", twist=0.3))
    opened(tab, plan)
    assert tab.one == LoadRobot("slider")
    assert tab.state.plan is not plan
    tab.take(RobotLoaded(load_robot("slider")))
    assert tab.state.plan is plan
    assert tab.state.robot.name == "slider"
    assert tab.state.given is None


def test_a_plan_that_waits_for_its_robot_is_dropped_when_something_else_is_asked_for(tab):
    opened(tab, plan_of(Jump(robot="slider", twist=0.3)))
    tab.take(Act.UNDO)
    assert tab.take(RobotLoaded(load_robot("slider"))) == ()
    assert tab.state.robot.name == tab.state.plan.jump.robot == "anymal"


def test_a_design_is_planned(tab):
    design = Design(JUMP, Tuning(limits={"friction": 0.4}), SCENARIO, "Mine", "Look at it.")
    opened(tab, design, "mine.jump.json")
    assert tab.task.jump == JUMP
    assert tab.state.design == design
    assert tab.state.note == "Look at it."


def test_numbers_that_no_design_may_have_are_refused(tab):
    huge = plan_of(JUMP)
    far = replace(huge, jump=replace(JUMP, twist=1e6))
    before = tab.state.design, tab.state.plan
    for holds in (far, replace(rollout(), jump=far.jump, plan=far)):
        opened(tab, holds, "far.npz")
        ((title, body),) = tab.notes()
        assert title == "Not opened"
        assert body.startswith("far.npz: ")
        assert "twist: expected" in body
        assert (tab.state.design, tab.state.plan) == before
        assert tab.state.pins == ()


# ---- for looking


def test_a_motion_without_a_plan_is_pinned(tab, states):
    shown = tab.state.shown
    opened(tab, states, "turn.csv")
    (pin,) = tab.state.pins
    assert (pin.design, pin.rollout, tab.state.pin_chosen) == (None, None, 0)
    assert tab.state.shown is shown
    assert tab.state.note == "turn.csv is pinned for looking and comparing, at 50 frames/s."
    tab.take(Act.USE_PINNED)
    assert tab.notes()[0][0] == "Not used"


def test_there_are_no_more_pins_than_colours(tab, states):
    for _ in PINNED:
        opened(tab, states, "turn.csv")
    assert {pin.colour for pin in tab.state.pins} == set(PINNED)
    opened(tab, states, "turn.csv")
    assert tab.notes() == [("Not opened", "turn.csv: unpin something first; all colours are taken")]
    assert len(tab.state.pins) == len(PINNED)


# ---- saving


def export(tab, *formats, of=PLAN):
    tab.take(FileChoice(formats[0], formats[1:], of))
    return tab.take(Act.EXPORT)


def test_a_design_is_saved_as_it_is(tab):
    tab.take(Act.SAVE)
    assert isinstance(tab.one, Download)
    assert load_design(tab.one.content) == tab.state.design


def test_there_must_be_something_to_export():
    tab = PureTab()
    export(tab, "npz")
    assert tab.one == Notify("Nothing to export", "There is no plan yet.")


def test_plan_or_simulation_is_exported(tab):
    export(tab, "npz", of="simulation")
    assert tab.task.trajectory is tab.state.plan  # there is no simulation
    tab.take(Act.SIMULATE)
    tab.finish_simulation()
    for of, trajectory in ((PLAN, tab.state.plan), ("simulation", tab.state.rollout)):
        export(tab, "npz", "csv", of=of)
        assert tab.one.queue is Queue.SAVE
        assert tab.task.trajectory is trajectory
        assert tab.state.files.saving_note == "Exporting npz, csv ..."


@pytest.mark.parametrize(
    ("report", "effect"),
    [
        (Exported(0, "a.npz", b"1"), Download("a.npz", b"1")),
        (Failed(0, "no room"), Notify("Not exported", "no room")),
        (Cancelled(0), Notify("Not exported", "Stopped: npz")),
    ],
)
def test_saving_ends(tab, report, effect):
    export(tab, "npz")
    submit = tab.submits[-1]
    tab.report(Progress(0, "writing"))
    assert tab.state.files.saving_note == "Exporting npz ..."
    tab.report(Progress(0, "waiting: others", waiting=True))
    assert tab.state.files.saving_note == "Exporting npz (waiting: others) ..."
    assert tab.take(Act.STOP_FILES) == (Stop(Queue.OPEN), Stop(Queue.SAVE))
    assert tab.report(report) == (effect,)
    assert (tab.state.files.saving, tab.state.files.saving_note) == (0, "")
    before = tab.state
    assert tab.report(report, submit=submit) == ()
    assert tab.state is before


def test_a_format_whose_package_is_missing_is_refused(tab, monkeypatch):
    name = next(name for name, each in FORMATS.items() if each.extra is not None)
    monkeypatch.setattr(type(FORMATS[name].extra), "missing", True)
    export(tab, name)
    ((title, body),) = tab.notes()
    assert title == "Not exported"
    assert "pip install" in body


def test_the_menu_says_what_cannot_be_written_of_the_robot(tab):
    tab.take(FileChoice("lowcmd"))
    choice = tab.state.file_choice
    assert [choice.title(name) for name in ("npz", "lowcmd")] == ["npz", "lowcmd (not available)"]
    assert "ANYmal B has" in choice.line("lowcmd")
    assert not is_enabled(Act.EXPORT, tab.state)
    tab.take(FileChoice("npz"))
    assert is_enabled(Act.EXPORT, tab.state)


def shown_exports(tab):
    tab.take(Act.CHOOSE_EXPORT)
    assert isinstance(tab.one, ShowExports)
    return tab.one


def test_the_dialog_has_every_format_by_what_it_is_for(tab):
    shown = shown_exports(tab)
    assert list(shown.groups) == ["For simulation", "For learning", "For the robot", "To look at"]
    every = {each["name"]: each for group in shown.groups.values() for each in group}
    assert list(every) == list(FORMATS)
    assert len({each["file"] for each in every.values()}) == len(every)
    assert every["unitree-csv"]["file"] == "anymal_twist90_forward1cm_unitree.csv"
    assert every["npz"]["hindrance"] == ""
    assert "ANYmal B has" in every["lowcmd"]["hindrance"]
    tab.take(Act.SIMULATE)
    tab.finish_simulation()
    assert shown_exports(tab).motion.startswith("the simulation of ANYmal B: 90°")
    tab.take(replace(tab.state.export, of=PLAN))
    assert shown_exports(tab).motion.startswith("the plan of ANYmal B: 90°")


def test_what_is_not_installed_says_how_to_get_it(tab, monkeypatch):
    for each in FORMATS.values():
        if each.extra is not None:
            monkeypatch.setattr(type(each.extra), "missing", True)
    _hindrance.cache_clear()
    (rrd,) = (each for each in shown_exports(tab).groups["To look at"] if each["name"] == "rrd")
    _hindrance.cache_clear()
    assert rrd["hindrance"] == 'not installed: pip install "llsrbm[rerun]"'


def test_a_choice_in_the_dialog_is_the_menus(tab):
    tab.take(FileChoice("npz", ("csv",), PLAN))
    tab.take(ExportChosen("unitree-csv"))
    assert (tab.state.export.format, tab.state.export.also) == ("unitree-csv", ())
    assert tab.task.formats == ("unitree-csv",)
    assert tab.task.options == {}
    assert not tab.task.zipped
    assert tab.take(ExportChosen("csv")) == ()  # one is being written
    tab.report(Cancelled(0))
    assert tab.take(ExportChosen("nosuch")) == ()
    tab.take(ExportChosen("lowcmd"))
    ((title, body),) = tab.notes()
    assert title == "Not exported"
    assert "ANYmal B has" in body


def test_there_is_nothing_to_choose_without_a_motion():
    assert not is_enabled(Act.CHOOSE_EXPORT, PureTab().state)
    assert PureTab().take(Act.CHOOSE_EXPORT) == ()
