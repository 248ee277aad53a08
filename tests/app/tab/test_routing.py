"""Routes that are clicked, dragged and typed: which requests they become, and undone."""

import math
from dataclasses import replace

import pytest

from app.panel.acts import Act
from app.panel.jump_types import of_chosen_type, title_of_type
from app.panel.route_controls import ChosenLanding
from app.panel.status import Verdict
from app.picture.ground_clicks import GroundClicked
from app.picture.landing_handles import LandingDragged
from app.tab import acts
from app.workers.reports import Planned
from llsrbm.request.design import dump_design, load_design
from llsrbm.request.jump import PLAIN
from llsrbm.request.jump_types import load_type
from llsrbm.request.route import MOST, Landing, waypoints
from tests.app.pure_tab import plan_of, planned_tab
from tests.app.synthetic_plan import refined_plan


def click(tab, x, y, ground=0.0):
    """From a camera 2 m above, behind the robot."""
    eye = (-3.0, 0.5, 2.0)
    ray = (x - eye[0], y - eye[1], ground - eye[2])
    return tab.take(GroundClicked(eye, ray))


def places(tab):
    return [place[:3] for place in waypoints(tab.state.design.jump.landings)]


def routed(*landings):
    tab = planned_tab()
    tab.take(tab.state.design.jump.along([Landing(**each) for each in landings]))
    tab.settle()
    return tab


def drawn(*clicks, **changes):
    tab = planned_tab(**changes)
    tab.take(Act.DRAW_ROUTE)
    for x, y in clicks:
        click(tab, x, y)
    return tab


def test_the_first_click_is_the_landing_and_each_further_one_goes_on():
    tab = drawn((0.302, 0.0), twist=1.0)
    jump = tab.state.design.jump
    assert (jump.type, jump.forward, jump.twist, jump.route) == (PLAIN, 0.3, 0.0, ())
    click(tab, 0.5, 0.1)
    click(tab, 0.8, 0.1)
    assert tab.state.design.jump.type == "hops"
    assert places(tab) == [pytest.approx(at) for at in ((0.3, 0, 0), (0.5, 0.1, 0), (0.8, 0.1, 0))]
    assert tab.state.chosen_landing.number == 2
    tab.settle()
    assert tab.state.plan.jump == tab.state.design.jump


def test_a_click_is_one_step_back():
    tab = drawn((0.3, 0.0), (0.5, 0.0), (0.8, 0.0))
    for count in (2, 1):
        tab.take(Act.UNDO)
        assert tab.state.design.jump.jumps == count
    tab.take(Act.REDO)
    tab.take(Act.UNDO)
    tab.take(Act.UNDO)
    click(tab, 0.2, 0.1)  # the first one again
    assert places(tab) == [pytest.approx((0.2, 0.1, 0.0))]


def test_a_click_goes_on_from_a_route_that_is_there_and_down_to_the_ground():
    tab = routed({"forward": 0.3, "height": 0.1}, {"forward": 0.3})
    tab.take(Act.DRAW_ROUTE)
    click(tab, 0.9, 0.0)
    assert places(tab)[1:] == [pytest.approx((0.6, 0, 0.1)), pytest.approx((0.9, 0, 0))]


def test_it_ends_with_as_many_landings_as_there_may_be():
    tab = drawn(*((0.2 * k, 0.0) for k in range(1, MOST + 1)))
    assert tab.state.design.jump.jumps == MOST
    assert tab.state.drawing is None
    assert not acts.is_enabled(Act.DRAW_ROUTE, tab.state)
    assert not acts.is_enabled(Act.ADD_LANDING, tab.state)


@pytest.mark.parametrize("ray", [(1.0, 0.0, 0.5), (1.0, 0.0, 0.0)])
def test_a_click_at_the_sky_is_none(ray):
    tab = drawn()
    before = tab.state
    assert tab.take(GroundClicked((0.0, 0.0, 1.0), ray)) == ()
    assert tab.state is before


def test_a_click_on_a_landing_or_while_nothing_is_drawn_is_none():
    tab = drawn((0.3, 0.0), (0.6, 0.0))
    assert click(tab, 0.62, 0.01) == ()
    tab.take(Act.STOP_DRAWING)
    assert click(tab, 0.9, 0.0) == ()
    assert len(places(tab)) == 2


def test_a_landing_too_far_away_is_refused_with_a_sentence():
    tab = drawn((0.3, 0.0))
    click(tab, 9.0, 0.0)
    assert len(places(tab)) == 1
    ((title, body),) = tab.notes()
    assert title == "No landing there"
    assert body == "route: landing 2: forward: expected -3 to 3 m, got 8.7"


def test_another_robot_or_design_is_not_drawn_on():
    tab = drawn((0.3, 0.0))
    tab.move(robot="go2")
    assert tab.state.drawing is None
    tab = drawn((0.3, 0.0))
    tab.take(load_design(dump_design(tab.state.design).encode()))
    assert tab.state.drawing is None


def test_a_landing_is_dragged_and_one_grip_is_one_step_back():
    tab = routed({"forward": 0.3}, {"forward": 0.3}, {"forward": 0.3})
    before = tab.state.design
    for landing in (0, 1):
        for step in range(3):
            at = 0.3 * (landing + 1) + 0.01 * (step + 1)
            tab.take(LandingDragged(at, 0.1, 0.0, landing, landing + 1, held=step < 2))
            tab.settle()  # the hand rests
    assert [place[:2] for place in places(tab)] == [
        pytest.approx(at) for at in ((0.33, 0.1), (0.63, 0.1), (0.9, 0.0))
    ]
    tab.take(tab.state.chosen_landing.but("height", 0.1))
    tab.take(Act.UNDO)
    assert places(tab)[1] == pytest.approx((0.63, 0.1, 0.0))
    tab.take(Act.UNDO)
    assert places(tab)[1][:2] == pytest.approx((0.6, 0.0))
    tab.take(Act.UNDO)
    assert tab.state.design == before


def test_landings_are_added_typed_and_removed():
    tab = planned_tab(robot="anymal", twist=math.pi / 2, forward=0.0)
    tab.take(Act.ADD_LANDING)
    assert places(tab) == [pytest.approx((0, 0, 0)), pytest.approx((0, 0.3, 0))]
    tab.take(tab.state.chosen_landing.but("height", 0.1))
    tab.take(Act.ADD_LANDING)
    tab.take(ChosenLanding.of(tab.state.design.jump, 1))
    tab.take(Act.REMOVE_LANDING)
    assert places(tab) == [pytest.approx((0, 0, 0)), pytest.approx((0, 0.6, 0.1))]
    tab.take(Act.UNDO)
    tab.take(Act.REMOVE_ROUTE)
    jump = tab.state.design.jump
    assert (jump.type, jump.twist, jump.route) == (PLAIN, math.pi / 2, ())
    assert not acts.is_enabled(Act.REMOVE_LANDING, tab.state)
    assert not acts.is_enabled(Act.REMOVE_ROUTE, tab.state)


def test_equal_hops_become_a_route_of_as_many_landings():
    tab = planned_tab(type="hops", hops=2, forward=0.2)
    tab.take(Act.ADD_LANDING)
    assert [landing.forward for landing in tab.state.design.jump.route] == [0.2, 0.2, 0.3]


@pytest.mark.parametrize("name", [PLAIN, "rear-last", "run-up"])
def test_another_jump_type_keeps_the_first_landing_alone(name):
    tab = routed({"forward": 0.2, "height": 0.1}, {"forward": 0.3})
    jump = of_chosen_type(tab.state.design.jump, title_of_type(name))
    tab.take(jump)
    jump = tab.state.design.jump
    assert (jump.type, jump.route, jump.hops) == (name, (), 1)
    assert (jump.forward, jump.height) == (0.2, 0.1)


def test_a_flip_has_no_route():
    tab = planned_tab(robot="anymal")
    turning = replace(tab.state.design.jump, type="flip", pitch=math.tau)
    tab.state = replace(tab.state, design=replace(tab.state.design, jump=turning))
    assert not acts.is_enabled(Act.DRAW_ROUTE, tab.state)
    assert not acts.is_enabled(Act.ADD_LANDING, tab.state)
    assert load_type("flip").default_jump().route == ()


def test_a_route_is_planned_once_by_the_whole_body():
    tab = routed({"forward": 0.2}, {"forward": 0.3})
    tab.state = replace(tab.state, whole_body=True)
    tab.take(tab.state.chosen_landing.but("height", 0.1))
    task = tab.submits[-1].task
    assert (task.patient, task.near) == (True, None)
    tab.report(Planned(0, refined_plan(plan_of(task.jump))))
    assert not tab.state.planning
    assert tab.told[0] is Verdict.FEASIBLE
    assert "follows" not in tab.told[1]
    assert tab.submits[-1].task is task  # nothing refines it


def test_another_robot_goes_along_the_same_route():
    tab = routed({"forward": 0.2}, {"forward": 0.3, "height": 0.1})
    route = tab.state.design.jump.route
    tab.move(robot="slider")
    assert tab.state.design.jump.route == route
