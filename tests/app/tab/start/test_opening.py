"""How a tab begins and how it comes back, as values."""

from dataclasses import replace

import pytest

from app.link import PageReady, PlayerMoved
from app.panel.acts import Act
from app.panel.status import SeedResult, Verdict
from app.plots.choice import FEWER
from app.tab.effects import (
    After,
    Keep,
    LoadRobot,
    Notify,
    Play,
    Queue,
    RobotLoaded,
    Seek,
    SetPlayback,
    Submit,
)
from app.tab.planning.dragging import REST
from app.tab.planning.requests import Rested
from app.tab.start.opening import TabOpened, example_design, left, resume
from app.workers.opened_file import OpenedFile
from app.workers.reports import Checked, Prepared, SeedDone, SimulatedSoFar
from app.workers.tasks import PlanJump, Prepare
from llsrbm.request.design import Design
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from llsrbm.robots import load_robot
from tests.app.planners import CERTIFICATE, turning_states
from tests.app.pure_tab import ROBOTS, PureTab, plan_of, planned_tab, rollout_of

EXAMPLE = example_design(ROBOTS["anymal"])
PAGE = PageReady(software=False)


AS_BEFORE = SetPlayback(1.0, loop=True)


def kinds(effects):
    return [type(effect) for effect in effects]


# ---- beginning


def test_the_first_robots_example_is_planned():
    tab = PureTab()
    tab.take(TabOpened())
    assert tab.one.task == PlanJump(EXAMPLE.jump)


def test_a_low_window_opens_with_two_charts():
    tab = PureTab()
    tab.take(replace(PAGE, height=800.0))
    assert tab.state.plots == FEWER
    assert len(FEWER.charts) == 2


@pytest.mark.parametrize("robot", [None, "anymal"])
def test_a_plan_that_is_known_is_shown_at_once(robot):
    tab, plan = PureTab(robot), plan_of(EXAMPLE.jump)
    tab.take(TabOpened(plan=plan))
    if robot is None:
        assert tab.one == LoadRobot("anymal")
        tab.take(RobotLoaded(load_robot("anymal")))
    assert kinds(tab.effects) == [Keep, Play]
    assert tab.state.plan is plan
    assert tab.told[0] is Verdict.DRAFT
    assert tab.submits == []
    assert tab.move() == ()


def test_a_kept_design_is_planned_though_another_plan_is_known():
    tab = PureTab()
    kept = Design(Jump(forward=0.2), scenario=Scenario(board=0.02))
    tab.take(TabOpened(kept, plan_of(EXAMPLE.jump)))
    assert tab.one.task.jump == kept.jump
    assert tab.state.design == kept


@pytest.mark.parametrize("playing", [False, True])
def test_a_page_that_lost_its_server_goes_on_where_it_was(playing):
    tab = PureTab()
    tab.take(TabOpened(plan=plan_of(EXAMPLE.jump), time=0.65, playing=playing))
    assert tab.effects[1:] == (Seek(0.65), *([Play()] if playing else []))


def test_a_design_that_cannot_be_read_is_noted_and_the_example_shown():
    tab = PureTab()
    tab.take(TabOpened(None, plan_of(EXAMPLE.jump), None, ("it is cut", "so is that")))
    assert tab.effects[0] == Notify("The last design was not opened", "it is cut; so is that")
    assert tab.state.plan.jump == EXAMPLE.jump


def test_a_servers_file_comes_before_a_kept_design():
    jump = Jump(robot="slider", twist=0.2)
    tab = PureTab()
    tab.take(TabOpened(Design(Jump(forward=0.2)), None, OpenedFile("mine.npz", plan_of(jump))))
    assert tab.one == LoadRobot("slider")
    tab.take(RobotLoaded(load_robot("slider")))
    assert tab.state.plan.jump == jump
    assert "mine.npz" in tab.told[1]


def test_beside_a_servers_motion_its_robots_example_is_planned():
    tab = PureTab()
    tab.take(TabOpened(file=OpenedFile("turn.csv", turning_states("go2"))))
    assert len(tab.state.pins) == 1
    assert tab.state.design == example_design(ROBOTS["go2"])
    check, prepare = (submit.task for submit in tab.of(Submit))
    assert check.motion.robot == "go2"
    assert prepare == Prepare("go2")


# ---- coming back


def back(tab, page=PAGE, tickets=0):
    """The tab after its connection has ended and it has come back."""
    tab.have(resume(left(tab.state), page, tickets))
    return tab


def test_everything_that_was_shown_is_there_again():
    tab = planned_tab()
    tab.take(Act.SIMULATE)
    tab.finish_simulation()
    tab.take(Act.PIN)
    tab.take(PlayerMoved(0.7, playing=False))
    before = tab.state
    assert back(tab).effects == (AS_BEFORE, Seek(0.7))
    after = tab.state
    for name in ("design", "robot", "shown", "status", "pins", "view", "plots", "history"):
        assert getattr(after, name) is getattr(before, name)
    assert not after.page


@pytest.mark.parametrize("playing", [True, False])
def test_a_page_that_was_never_away_knows_best_where_it_is(playing):
    tab = planned_tab()
    tab.take(PlayerMoved(0.4, playing=not playing))
    back(tab, replace(PAGE, time=0.9, playing=playing))
    assert tab.effects == (AS_BEFORE, Seek(0.9), Play())[: 2 + playing]


def test_a_running_job_is_begun_again_under_another_ticket():
    tab = planned_tab()
    tab.take(Act.SIMULATE)
    old = tab.submits[-1]
    rollout = rollout_of(plan_of(tab.state.plan.jump))
    tab.report(SimulatedSoFar(0, 0.1, rollout.time[:50:7], rollout.qpos[:50:7]))
    back(tab, tickets=40)
    submit = tab.of(Submit)[0]
    assert submit.task is old.task
    assert submit.ticket == 41
    assert tab.state.shown.so_far is None
    before = tab.state
    tab.report(Prepared(0, "go2"), submit=replace(submit, ticket=40))
    assert tab.state is before
    tab.finish_simulation()
    assert tab.told[0] is Verdict.LANDED


def test_seeds_that_are_done_stay_while_something_else_is_planned():
    tab = planned_tab()
    tab.take(Act.SEEDS)
    done = (SeedResult(0, True, True, None, 0.0, "landed"),) * 2
    seeds = replace(tab.state.seeds, results=done, worst=rollout_of(tab.state.plan))
    tab.state = replace(tab.state, seeds=seeds)
    tab.move(forward=0.1)
    back(tab)
    assert tab.state.seeds.results == done
    tab.take(Act.WORST)
    assert tab.state.rollout is not None


def test_a_request_that_rested_rests_again():
    tab = planned_tab()
    tab.move(forward=0.1)
    tab.finish_plan()
    back(tab)
    (after,) = tab.of(After)
    assert (after.seconds, after.event) == (REST, Rested(tab.state.work.dragging.rest))
    tab.take(after.event)
    assert tab.one.task == PlanJump(tab.state.design.jump)


def test_a_robot_that_was_being_loaded_is_loaded_again():
    tab = planned_tab()
    tab.move(robot="go2")
    tab.report(Prepared(0, "go2"))
    assert tab.of(LoadRobot)
    back(tab)
    tab.settle()
    assert tab.state.plan.jump.robot == "go2"


def test_a_plan_that_waited_for_its_robot_is_shown():
    tab, plan = PureTab(robot=None), plan_of(EXAMPLE.jump)
    tab.take(TabOpened(plan=plan))
    back(tab)
    assert tab.one == LoadRobot("anymal")
    tab.take(RobotLoaded(load_robot("anymal")))
    assert tab.state.plan is plan


def test_meshes_that_were_being_made_are_made_again():
    tab = planned_tab()
    tab.state = replace(tab.state, prepared=False)
    back(tab)
    (submit,) = tab.of(Submit)
    assert (submit.queue, submit.task) == (Queue.ROBOT, Prepare("anymal"))


def test_a_motion_that_played_plays_on():
    tab = planned_tab()
    tab.take(PlayerMoved(0.4, playing=True))
    assert back(tab).effects == (AS_BEFORE, Seek(0.4), Play())


def test_seeds_are_counted_from_the_first_again():
    tab = planned_tab()
    tab.take(Act.SEEDS)
    tab.report(SeedDone(0, SeedResult(0, True, True, None, 0.0, "landed"), 1, 2))
    back(tab)
    assert tab.state.seeds.results == ()


def test_a_check_is_begun_again_and_a_file_that_was_written_is_said_to_be_lost():
    """Neither is waited for for ever."""
    tab = planned_tab()
    tab.take(Act.EXPORT)
    tab.take(Act.CHECK)
    old = tab.one
    back(tab)
    (submit,) = tab.of(Submit)
    assert (submit.task.motion, submit.ticket > old.ticket) == (old.task.motion, True)
    ((title, _),) = tab.notes()
    assert (title, tab.state.files.saving_note) == ("Stopped", "")
    tab.report(Checked(0, CERTIFICATE))
    assert tab.state.check.certificate is CERTIFICATE
    assert back(tab).of(Submit) == []
