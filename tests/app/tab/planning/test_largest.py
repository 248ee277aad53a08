"""How far?: a search beside all else, its sentence, and the jump that is taken."""

import math
from dataclasses import replace

import pytest

from app.link import PageReady
from app.panel.acts import HOW_FAR, Act
from app.panel.status import Verdict
from app.tab.acts import is_enabled, is_visible
from app.tab.effects import Forget, Queue, Stop
from app.tab.how_far import direction_of
from app.tab.start.opening import left, resume
from app.workers.reports import Cancelled, Failed, FoundLargest, Progress, Refused
from app.workers.tasks import FindLargest
from llsrbm.largest_jump import DIRECTIONS, Largest
from llsrbm.request.design import Design
from llsrbm.request.jump import Jump
from llsrbm.request.tuning import Tuning
from tests.app.pure_tab import plan_of, planned_tab
from tests.app.synthetic_plan import refined_plan

LIMIT = "RH_KFE is at its limit of 30.1 rad/s at lift-off"


@pytest.fixture
def tab():
    return planned_tab(twist=0.5)


def sentence(tab):
    return tab.state.far.sentence(tab.state.design)


def found(tab, steps=88):
    """The search comes to so many steps."""
    task = tab.submits[-1].task
    direction = DIRECTIONS[task.towards]
    plan = refined_plan(plan_of(direction.of(task.jump, steps)))
    largest = Largest(task.towards, direction.value(steps), direction.unit, LIMIT, plan)
    return tab.report(FoundLargest(0, largest))


def searched(tab, act=Act.FAR_FORWARD, steps=88):
    tab.take(act)
    found(tab, steps)
    return tab


@pytest.mark.parametrize(
    ("component", "value", "towards"),
    [
        ("twist", 0.0, "twist"),
        ("twist", -0.2, "twist-right"),
        ("forward", 0.1, "forward"),
        ("forward", -0.1, "backward"),
        ("lateral", 0.0, "lateral"),
        ("lateral", -0.1, "lateral-right"),
        ("height", 0.0, "up"),
        ("height", -0.1, "down"),
    ],
)
def test_it_is_searched_towards_the_side_of_the_slider(component, value, towards):
    assert direction_of(component, value) == towards
    tab = planned_tab(**{component: value})
    tab.take(HOW_FAR[component])
    assert (tab.one.queue, tab.one.task.towards) == (Queue.LARGEST, towards)
    assert tab.one.task.jump == tab.state.design.jump


def test_it_says_how_far_it_has_come_and_then_what_stops_more(tab):
    tab.take(Act.FAR_FORWARD)
    assert sentence(tab) == "Forward: waiting for a computing process ..."
    tab.report(Progress(0, "0.65 m holds, trying 0.70 m"))
    assert sentence(tab) == "Forward: 0.65 m holds, trying 0.70 m ..."
    before = tab.state.status
    found(tab)
    assert sentence(tab) == f"Forward: 0.88 m is the largest found; what stops it: {LIMIT}."
    assert tab.state.status is before, "the verdict is on the motion that is shown"
    searched(tab, Act.FAR_TWIST, 195)
    assert sentence(tab).startswith("Twist to the left: 195° is the largest found;")


def test_the_slider_reaches_to_what_was_found_whether_it_is_taken_or_not(tab):
    assert tab.state.ends.forward == (-0.3, 0.6)
    searched(tab)
    assert tab.state.ends.forward == (-0.3, 0.88)
    searched(tab, steps=70)
    assert tab.state.ends.forward == (-0.3, 0.88)
    assert tab.state.ends.lateral == tab.state.file.task.lateral


def test_sliders_reach_to_what_is_asked_for_by_a_link(tab):
    tab.take(Design(Jump(robot="anymal", forward=-0.655)))
    assert tab.state.ends.forward == (pytest.approx(-0.66), 0.6)
    tab.move(forward=0.1)
    assert tab.state.ends.forward[0] == pytest.approx(-0.66)
    tab.take(Design(Jump(robot="slider")))
    assert tab.state.ends == tab.state.file.task


def test_what_was_found_is_taken_with_its_plan_and_can_be_undone(tab):
    before = tab.state.design
    searched(tab)
    assert is_visible(Act.USE_LARGEST, tab.state)
    tab.take(Act.USE_LARGEST)
    assert tab.state.design.jump == replace(before.jump, forward=0.88)
    assert tab.state.plan is tab.state.far.found.plan
    assert tab.state.status.verdict is Verdict.FEASIBLE
    assert not tab.state.planning
    assert not is_visible(Act.USE_LARGEST, tab.state)
    assert "Of the request before" not in sentence(tab)
    tab.take(Act.UNDO)
    assert tab.state.design == before


@pytest.mark.parametrize("changes", [{"twist": 0.6}, {"forward": 0.2}])
def test_a_slider_that_moves_ends_the_search(tab, changes):
    tab.take(Act.FAR_FORWARD)
    late = tab.submits[-1]
    tab.move(**changes)
    assert tab.of(Forget) == [Forget(Queue.LARGEST)]
    assert sentence(tab) == "Forward: not searched to the end, as the request has changed."
    state = tab.state
    tab.report(Progress(0, "late"), submit=late)
    assert tab.state is state


def test_of_another_request_it_says_so_and_is_not_offered(tab):
    searched(tab)
    tab.move(forward=0.2)  # of the same component alone
    assert is_visible(Act.USE_LARGEST, tab.state)
    tab.move(lateral=0.05)
    assert sentence(tab).startswith("Of the request before. Forward: 0.88 m")
    assert not is_visible(Act.USE_LARGEST, tab.state)
    before = tab.state
    tab.take(Act.USE_LARGEST)
    assert tab.state is before
    tab.move(lateral=0.0)
    tab.take(Tuning(limits={"friction": 0.3}))
    assert sentence(tab).startswith("Of the request before.")


def test_cancel_ends_it_and_leaves_nothing(tab):
    assert not is_visible(Act.CANCEL, tab.state)
    tab.take(Act.FAR_HEIGHT)
    submit = tab.submits[-1]
    assert is_visible(Act.CANCEL, tab.state)
    assert Stop(Queue.LARGEST) in tab.take(Act.CANCEL)
    tab.report(Cancelled(0), submit=submit)
    assert tab.state.far is None
    assert not is_visible(Act.CANCEL, tab.state)
    assert tab.state.status.verdict is not Verdict.CANCELLED


def test_where_there_is_none_it_says_why(tab):
    tab.take(Act.FAR_HEIGHT)
    jump = tab.submits[-1].task.jump
    tab.report(Refused(0, jump, "no motion was found", plan_of(jump, "not-converged")))
    assert sentence(tab) == "Up: no motion was found."
    tab.take(Act.FAR_HEIGHT)
    tab.report(Failed(0, "The server is busy."))
    assert sentence(tab) == "Up: The server is busy."
    assert not tab.state.far.running


def test_flips_are_not_searched(tab):
    tab.take(Design(Jump(robot="go2", type="flip", pitch=-math.tau)))
    tab.finish_robot()
    for act in HOW_FAR.values():
        assert not is_enabled(act, tab.state)
        assert tab.take(act) == ()


def test_it_goes_with_its_robot_and_goes_on_when_a_tab_comes_back(tab):
    tab.take(Act.FAR_FORWARD)
    tab.have(resume(left(tab.state), PageReady(software=True)))
    (again,) = [each for each in tab.submits[1:] if isinstance(each.task, FindLargest)][1:]
    assert again.ticket == tab.state.far.ticket
    found(tab)
    tab.take(Jump(robot="slider"))
    tab.finish_robot()
    assert tab.state.far is None
