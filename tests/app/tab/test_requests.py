"""Requests of a visitor, as values: no server, no thread, no planner."""

from dataclasses import replace

import pytest

from app.panel.acts import Act
from app.panel.status import Verdict
from app.tab.acts import Corrected
from app.tab.effects import (
    After,
    Keep,
    LoadRobot,
    Notify,
    Queue,
    RobotLoaded,
    RobotMissing,
    Stop,
    Submit,
)
from app.tab.planning.dragging import REST
from app.tab.planning.requests import Rested
from app.tab.start.opening import example_design
from app.workers.reports import Prepared
from app.workers.tasks import PlanJump, Prepare, SimulateJump, SimulateSeeds
from llsrbm.request.design import Design
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from llsrbm.request.tuning import Tuning
from llsrbm.robots import load_robot
from tests.app.pure_tab import ROBOTS, PureTab, planned_tab

EXAMPLE = Design(Jump(forward=0.2), Tuning(limits={"friction": 0.2}), title="Ice", note="Look.")


@pytest.fixture
def tab():
    return planned_tab()


# ---- planning while a slider moves


def test_the_first_request_is_planned_with_patience_and_played():
    tab = PureTab()
    tab.move(forward=0.1)
    submit = tab.submits[-1]
    assert submit.queue is Queue.MOTION
    assert submit.task == PlanJump(tab.state.design.jump)
    assert tab.told[0] is Verdict.PLANNING
    assert tab.state.status.busy
    tab.finish_plan()
    assert [type(effect).__name__ for effect in tab.effects] == ["Play", "Keep"]
    assert tab.told[0] is Verdict.DRAFT
    assert tab.state.plan.jump.forward == 0.1


def test_a_moving_slider_is_followed_quickly_from_what_is_shown(tab):
    shown = tab.state.plan
    tab.move(forward=0.05)
    assert tab.task == PlanJump(tab.state.design.jump, near=shown, patient=False)
    (after,) = tab.of(After)
    assert vars(after) == {"seconds": REST, "event": Rested(tab.state.work.dragging.rest)}
    assert tab.finish_plan() == ()
    assert tab.told[0] is Verdict.DRAFT
    assert tab.state.status.busy
    assert tab.state.plan.jump.forward == 0.05


def test_a_request_that_has_rested_is_planned_from_scratch_and_kept(tab):
    tab.move(forward=0.05)
    tab.finish_plan()
    tab.wait()
    assert tab.task == PlanJump(tab.state.design.jump)
    tab.finish_plan()
    assert tab.one == Keep(tab.state.design)
    assert tab.told[0] is Verdict.DRAFT
    assert not tab.state.status.busy


def test_a_rest_that_is_over_before_the_quick_answer_ends_with_it(tab):
    tab.move(forward=0.05)
    assert tab.wait() == ()
    tab.finish_plan()
    (after,) = tab.of(After)
    assert vars(after) == {"seconds": 0.0, "event": Rested(tab.state.work.dragging.rest)}
    tab.wait()
    assert tab.task == PlanJump(tab.state.design.jump)


def test_a_rest_that_was_broken_off_leads_to_nothing(tab):
    tab.move(forward=0.05)
    rested = tab.due[Rested].event
    tab.finish_plan()
    tab.move(forward=0.06)
    assert tab.take(rested) == ()
    tab.finish_plan()
    assert tab.take(rested) == ()  # of the rest before


@pytest.mark.parametrize(
    "change", [{"twist": 2.2}, {"twist": 0.9}, {"forward": 0.2}, {"lateral": -0.2}, {"height": 0.2}]
)
def test_from_far_away_it_is_quicker_to_start_anew(tab, change):
    tab.move(**change)
    assert (tab.task.near, tab.task.patient) == (None, False)


def test_what_did_not_converge_or_is_of_another_model_is_no_start(tab):
    tab.move(model="srbm")
    assert (tab.task.near, tab.task.patient) == (None, True)
    tab.finish_plan(status="not-converged")
    tab.move(forward=0.05)
    assert (tab.task.near, tab.task.patient) == (None, True)


def test_free_arms_are_no_start_for_held_ones():
    tab = planned_tab(robot="g1")
    tab.move(arms="held")
    assert (tab.task.near, tab.task.patient) == (None, True)


@pytest.mark.parametrize(
    ("robot", "arms"), [("anymal", "free"), ("g1_legs", "free"), ("g1", "held")]
)
def test_a_robot_without_arms_holds_none(robot, arms):
    tab = planned_tab(robot="g1", arms="held")
    tab.move(robot=robot)
    assert tab.state.design.jump.arms == arms


def test_the_same_request_is_not_planned_twice(tab):
    before = tab.state.design
    assert tab.move() == ()
    assert tab.state.design is before
    tab.move(forward=0.05)
    assert tab.move() == ()


def test_cancel_ends_a_rest_too(tab):
    tab.move(forward=0.05)
    tab.finish_plan()
    rested = tab.due[Rested].event
    assert tab.take(Act.CANCEL) == (Stop(Queue.MOTION),)
    assert tab.told[0] is Verdict.CANCELLED
    assert not tab.state.status.busy
    assert tab.take(rested) == ()
    tab.move()  # the same request counts as a new one
    assert isinstance(tab.task, PlanJump)


def test_other_weights_and_limits_are_planned(tab):
    tuning = Tuning(limits={"friction": 0.3})
    tab.take(tuning)
    assert tab.task.tuning == tuning
    tab.move(forward=0.1)
    assert tab.state.design.tuning == tuning


def test_corrections_are_noted(tab):
    jump = replace(tab.state.design.jump, forward=0.6)
    tab.take(Corrected(jump, ("Forward [m]: too far", "Lateral [m]: too far")))
    _, _, *after = tab.effects
    assert after == [Notify("Corrected", "Forward [m]: too far; Lateral [m]: too far")]
    tab.take(Corrected(Scenario(), ("Seed: too large",)))
    assert tab.effects[1:] == (Notify("Corrected", "Seed: too large"),)


# ---- undone and done again


def steps_back(tab):
    """Designs on the way back, and the tab is where it was."""
    found, here = [], tab.state.design
    while tab.state.history.back:
        tab.take(Act.UNDO)
        found.append(tab.state.design)
    for _ in found:
        tab.take(Act.REDO)
    assert tab.state.design == here
    return found


def test_changes_of_the_same_number_are_one_step_back():
    tab = planned_tab()
    first = len(tab.state.history.back)
    for forward in (0.05, 0.1, 0.15):
        tab.move(forward=forward)
    for twist in (0.1, 0.2):
        tab.move(twist=twist)
    assert len(tab.state.history.back) == first + 2
    tab.take(Act.UNDO)
    assert (tab.state.design.jump.forward, tab.state.design.jump.twist) == (
        0.15,
        pytest.approx(1.5708),
    )
    tab.take(Act.UNDO)
    assert tab.state.design.jump.forward == 0.01
    assert tab.state.plan.jump.forward == 0.01  # which was planned
    assert not tab.of(Submit)


def test_a_number_that_rested_begins_another_step(tab):
    first = len(tab.state.history.back)
    for forward in (0.05, 0.1):
        tab.move(forward=forward)
        tab.settle()
    assert len(tab.state.history.back) == first + 2


def test_every_design_comes_back_and_forth(tab):
    designs = [tab.state.design]
    for event in (
        lambda: replace(tab.state.design.jump, lateral=0.1),
        lambda: Scenario(board=0.02),
        lambda: EXAMPLE,
        lambda: replace(tab.state.design.jump, robot="go2"),
        lambda: Tuning(weights={"force": 2.0}),
    ):
        tab.take(event())
        designs.append(tab.state.design)
    assert len(set(map(repr, designs))) == len(designs)
    assert steps_back(tab)[: len(designs) - 1] == designs[-2::-1]


def test_a_change_ends_what_could_be_done_again(tab):
    tab.move(forward=0.1)
    tab.take(Act.UNDO)
    assert tab.state.history.forth
    tab.move(lateral=0.1)
    assert not tab.state.history.forth
    assert tab.take(Act.REDO) == ()


def test_the_oldest_designs_are_let_go(tab):
    for number in range(120):
        tab.take(replace(EXAMPLE, title=f"{number}"))
    assert len(tab.state.history.back) == 100
    assert tab.state.history.back[-1].title == "118"


def test_nothing_to_undo_is_nothing():
    tab = PureTab()
    before = tab.state
    assert tab.take(Act.UNDO) == tab.take(Act.REDO) == ()
    assert tab.state is before


def test_an_examples_note_goes_and_comes_with_it(tab):
    tab.take(EXAMPLE)
    assert (tab.state.note, tab.state.design) == ("Look.", EXAMPLE)
    tab.move(forward=0.25)
    assert (tab.state.note, tab.state.design.title, tab.state.design.note) == ("", "", "")
    assert tab.state.design.tuning == EXAMPLE.tuning
    tab.take(Act.UNDO)
    assert (tab.state.note, tab.state.design) == ("Look.", EXAMPLE)


# ---- robots


def test_another_robot_brings_its_example_and_is_prepared_first(tab):
    tab.move(robot="slider", forward=0.6)
    example = example_design(ROBOTS["slider"]).jump
    assert tab.state.design == Design(example)
    assert tab.task == Prepare("slider")
    assert (tab.state.robot.name, tab.state.ready) == ("anymal", False)
    tab.move()
    assert tab.effects == ()  # it is under way
    tab.report(Prepared(0, "slider"))
    assert tab.one == LoadRobot("slider")
    tab.take(RobotLoaded(load_robot("slider")))
    assert tab.task == PlanJump(example)
    assert tab.state.shown is None
    tab.finish_plan()
    assert tab.state.plan.jump == example


def test_a_robot_that_is_not_wanted_any_more_is_not_drawn(tab):
    tab.move(robot="go2")
    tab.report(Prepared(0, "go2"))
    tab.take(Act.UNDO)  # while it is loaded
    assert tab.take(RobotLoaded(load_robot("go2"))) == ()
    assert tab.take(RobotMissing("go2", "no meshes")) == ()
    assert tab.state.robot.name == "anymal"
    assert tab.state.plan.jump.robot == "anymal"
    assert tab.told[1] != "no meshes"


def test_a_robot_that_cannot_be_drawn_is_a_sentence(tab):
    tab.move(robot="go2")
    tab.report(Prepared(0, "go2"))
    tab.take(RobotMissing("go2", "no meshes"))
    assert tab.told == (Verdict.FAILED, "no meshes")
    tab.move(lateral=0.1)  # another try
    assert tab.task == Prepare("go2")


# ---- simulations


@pytest.mark.parametrize(
    ("press", "kind"), [(Act.SIMULATE, SimulateJump), (Act.SEEDS, SimulateSeeds)]
)
def test_the_plan_that_is_awaited_is_simulated_when_it_has_rested(tab, press, kind):
    tab.move(forward=0.1)
    assert tab.take(press) == ()
    tab.finish_plan()
    tab.wait()
    tab.finish_plan()
    (submit,) = (effect for effect in tab.effects if not isinstance(effect, Keep))
    assert isinstance(submit.task, kind)
    assert submit.task.plan.jump.forward == 0.1
    assert tab.state.work.simulate_next is None


@pytest.mark.parametrize("event", [Act.CANCEL, Act.UNDO, EXAMPLE, Scenario(seed=1)])
def test_it_is_not_simulated_when_something_else_was_asked_for_meanwhile(tab, event):
    tab.move(forward=0.1)
    tab.take(Act.SIMULATE)
    tab.take(event)
    assert tab.state.work.simulate_next is None


def test_seeds_are_simulated_in_turn(tab):
    tab.take(Act.SEEDS)
    assert tab.task.seeds == tuple(range(20))
    assert (tab.state.seeds.plan, tab.state.seeds.count) == (tab.state.plan, 20)


def test_there_must_be_a_plan_that_converged():
    tab = PureTab()
    tab.take(Act.SIMULATE)
    assert tab.notes() == [("Not simulated", "There is no plan yet.")]
    tab = planned_tab()
    tab.move(robot="slider")
    tab.take(Act.SIMULATE)
    assert tab.notes() == [("Not simulated", "There is no plan yet.")]
    tab = PureTab()
    tab.move(forward=0.1)
    tab.finish_plan(status="not-converged")
    tab.take(Act.SIMULATE)
    assert tab.notes() == [
        ("Not simulated", "The planner did not converge, so there is no motion to follow.")
    ]


def test_cancel_leaves_an_export_alone(tab):
    tab.take(Act.EXPORT)
    tab.move(forward=0.1)
    assert tab.take(Act.CANCEL) == (Stop(Queue.MOTION),)
    assert tab.state.files.saving


def test_a_robot_disturbed_again_is_disturbed_as_much(tab):
    tab.take(Scenario(seed=3, noise=2.0))
    tab.take(Scenario())
    tab.take(Scenario(seed=3))
    assert tab.state.design.scenario.noise == 2.0


def test_what_is_entered_while_a_robot_is_prepared_counts(tab):
    tab.move(robot="go2")
    tab.move(lateral=0.2)
    tab.settle()
    assert (tab.state.plan.jump.robot, tab.state.plan.jump.lateral) == ("go2", 0.2)
