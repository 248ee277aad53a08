"""What a slider that moves is answered with, beside what it is answered with when it rests."""

import math
from dataclasses import replace

import numpy as np
import pytest

import llsrbm
from llsrbm.errors import NotConverged
from llsrbm.planning.answer.first_feasible import first_feasible, with_bounds_nearby
from llsrbm.planning.answer.nearest import distance
from llsrbm.planning.answer.planner import planner_for
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.violations import TOLERANCE, excess
from llsrbm.planning.solve.watch import Watch
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot

ANYMAL = load_robot("anymal")
LIMITS = {"torque_share": 0.56}
START = Jump(twist=math.radians(96))
DEGREES = (99, 153, 171, 108)  # of a slider, there and back


def answer(jump, near=None, **options):
    """The plan of a request, or of the nearest jump that is found."""
    try:
        return llsrbm.plan(jump, near=near, limits=LIMITS, draft=True, explains=False, **options)
    except NotConverged as error:
        return error.nearest


@pytest.fixture(scope="module")
def drag():
    """(request, plan that is shown) of every step."""
    shown, steps = answer(START), []
    for degrees in DEGREES:
        jump = replace(START, twist=math.radians(degrees))
        shown = answer(jump, near=shown, hurried=True)
        steps.append((jump, shown))
    return steps


@pytest.fixture(scope="module")
def rested():
    """The plan that is shown where the slider has come to rest."""
    return answer(replace(START, twist=math.radians(max(DEGREES))))


def test_no_step_is_without_a_motion_and_every_motion_satisfies_all_limits(drag):
    for jump, plan in drag:
        assert plan is not None, jump
        assert plan.solved
        assert max(v.amount for v in plan.violations.values()) <= TOLERANCE
        assert np.abs(plan.joint_torque[:-1]).max() <= (0.56 + 0.1) * 40.0 + TOLERANCE
        turned = plan.base_quat[-1]
        assert 2 * math.atan2(turned[3], turned[0]) == pytest.approx(plan.jump.twist, abs=2e-3)


def test_it_does_what_is_asked_as_far_as_that_is_possible_and_never_more(drag):
    twists = [(jump.twist, plan.jump.twist) for jump, plan in drag]
    assert all(done <= asked + 1e-9 for asked, done in twists)
    assert [done for asked, done in twists if asked < math.radians(115)] == [
        asked for asked, _ in twists if asked < math.radians(115)
    ]
    beyond = [plan for jump, plan in drag if jump.twist > math.radians(150)]
    assert all(plan.is_nearest for plan in beyond)


def test_what_a_slider_rests_at_is_about_what_was_shown_while_it_moved(drag, rested):
    jump, rough = max(drag, key=lambda step: step[0].twist)
    task = make_task(jump, ANYMAL, None, LIMITS)
    apart = distance(task, rough.jump) - distance(task, rested.jump)
    assert abs(apart) < 0.05  # of the range; 18 degrees


def test_where_nothing_is_given_up_the_solution_is_the_plan():
    planner = planner_for("anymal", START.model)
    near = planner.plan(replace(START, twist=1.1))
    jump = replace(START, twist=1.2)
    task = make_task(jump, ANYMAL)
    found = first_feasible(planner.formulation, task, (near.jump, near.solution.variables), Watch())
    assert found.plain.task.jump == jump
    assert found.plain.solved


def test_what_the_body_said_nearby_is_in_the_bounds(rested):
    """Where drives give no more, a step that is solved with it is objected to less."""
    form = planner_for("anymal", START.model).formulation
    task = make_task(replace(rested.jump, lateral=0.01), ANYMAL, None, LIMITS)
    minded = with_bounds_nearby(form, task, rested.jump, rested.solution)
    assert minded.jump == task.jump
    without, with_it = (
        excess(form.follow(each, rested.solution, Watch()).violations) for each in (task, minded)
    )
    assert without > TOLERANCE
    assert with_it < without / 2


def test_what_is_known_of_a_plan_nearby_is_as_if_it_was_judged_anew(rested, monkeypatch):
    planner = planner_for("anymal", START.model)
    form = planner.formulation
    task = make_task(replace(START, lateral=0.02), ANYMAL)
    near = planner.plan(replace(START, lateral=0.01))
    judged = with_bounds_nearby(form, task, near.jump, near.solution)
    monkeypatch.setattr(type(form), "judged", None)  # which would be an error
    known = with_bounds_nearby(form, task, near.jump, near.solution, [planner.last])
    for name, bounds in judged.agreed_bounds.items():
        for side in ("lower", "upper"):
            expected, found = getattr(bounds, side), getattr(known.agreed_bounds[name], side)
            assert found == pytest.approx(expected, abs=1e-9, nan_ok=True)
