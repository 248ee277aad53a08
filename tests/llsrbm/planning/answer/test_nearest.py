"""The nearest jump that can be planned, and what stops the rest, judged by plans of their own."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import llsrbm
from llsrbm.errors import Cancelled, InputError, JointNeed, NotConverged, Stop
from llsrbm.mechanics import turns_about_z
from llsrbm.ocp.solvers import FROM_GUESS
from llsrbm.planning.answer.nearest import distance, find_nearest
from llsrbm.planning.answer.planner import BY_NEARER, planner_for
from llsrbm.planning.answer.reasons import gains, sentence, stops_at
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.violations import TOLERANCE
from llsrbm.planning.solve.jump_layout import layout_of
from llsrbm.planning.solve.watch import Watch
from llsrbm.request.jump import STEPS, Jump, changes
from llsrbm.robots import load_robot

ANYMAL = load_robot("anymal")
LIMITS = {"torque_share": 0.5}
FAR = Jump(twist=math.radians(160))  # its torques are too small for it


def refusal(jump, **options):
    with pytest.raises(NotConverged) as caught:
        llsrbm.plan(jump, guesses=False, limits=LIMITS, draft=True, **options)
    return caught.value


@cache
def refused_and_found():
    """The refusal of the far request, and the nearest jump with all that its search knows."""
    found = []

    def find(*given, **named):
        found.append(find_nearest(*given, **named))
        return found[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("llsrbm.planning.answer.planner.find_nearest", find)
        return refusal(FAR), found[0]


def refused():
    return refused_and_found()[0]


def test_it_is_a_plan_of_a_round_request():
    plan = refused().nearest
    assert plan.solved
    assert plan.tuning.limits == LIMITS
    assert max(v.amount for v in plan.violations.values()) <= TOLERANCE
    assert np.abs(plan.joint_torque[:-1]).max() <= (0.5 + 0.1) * 40.0 + TOLERANCE
    steps = plan.jump.twist / STEPS["twist"]
    assert steps == pytest.approx(round(steps), abs=1e-6)
    assert 100 < round(steps) < 170
    assert plan.jump == replace(FAR, twist=plan.jump.twist)
    # Where it ends, from its arrays alone.
    turned = plan.base_quat[-1]
    assert 2 * math.atan2(turned[3], turned[0]) == pytest.approx(plan.jump.twist, abs=2e-3)


@pytest.mark.nightly
def test_its_single_feet_land_where_they_shall():
    stones = {"LF": (0.05, 0.03), "RH": (-0.03, 0.0)}
    plan = refusal(replace(FAR, stones=stones), explains=False).nearest
    assert plan.solved
    aside = plan.foot_position[-1] @ turns_about_z(plan.jump.twist) - ANYMAL.feet
    expected = [(0.05, 0.03, 0), (0, 0, 0), (0, 0, 0), (-0.03, 0, 0)]
    np.testing.assert_allclose(aside, expected, atol=1e-6)


def test_the_error_says_it_in_one_line():
    error = refused()
    assert "\n" not in str(error)
    assert error.reason in str(error)
    assert str(error).endswith(changes(FAR, error.nearest.jump))
    assert error.reason == sentence(error.stops) == str(error.stops[0])


def test_the_limit_that_is_named_first_is_the_one():
    """Changed as it says, it alone makes the jump plannable."""
    first = refused().stops[0]
    assert (first.constraint, first.limit, first.value) == ("joint_torque", "torque_share", 0.5)
    assert first.needed > 0.5
    assert first.demand.joint in ANYMAL.joint_names
    assert first.demand.unit == "Nm"
    assert first.demand.needed > first.demand.has
    assert llsrbm.plan(FAR, limits={"torque_share": first.needed}, draft=True).solved


def test_in_a_hurry_limits_are_named_without_amounts():
    first = stops_at(refused_and_found()[1])[0]
    assert (first.limit, first.amount) == ("torque_share", 0)
    assert f"{first.demand.joint} is at its " in str(first)


def test_a_request_beyond_starts_from_the_nearest_that_is_shown():
    shown = refused().nearest
    assert shown.is_nearest
    more = replace(FAR, twist=math.radians(175))
    error = refusal(more, near=shown, explains=False, hurried=True)
    # What was not tried is not solved, and of what was asked.
    assert (error.plan.report.status, error.plan.jump) == ("not-converged", more)
    assert max(v.amount for v in error.plan.violations.values()) > TOLERANCE
    assert error.nearest.solved
    assert error.nearest.jump.twist == pytest.approx(shown.jump.twist, abs=math.radians(8))
    assert error.stops[0].amount == 0
    # What is shown can be asked for; the check of the whole body may cost it two degrees.
    try:
        again = replace(FAR, twist=shown.jump.twist)
        back = llsrbm.plan(again, near=shown, limits=LIMITS, draft=True, explains=False)
    except NotConverged as error:
        back = error.nearest
    assert back.solved
    assert back.jump.twist == pytest.approx(shown.jump.twist, abs=math.radians(3))


@pytest.mark.nightly
def test_of_several_ways_to_less_the_one_that_keeps_most_is_found():
    """Half of the request as the guess leads to 81 degrees; nothing changes its sign or grows."""
    jump = Jump(twist=math.pi, height=0.3)
    with pytest.raises(NotConverged) as caught:
        llsrbm.plan(jump, guesses=False, explains=False, draft=True)
    found = caught.value.nearest
    assert found.solved
    assert found.jump == replace(jump, twist=found.jump.twist)
    assert math.radians(95) <= found.jump.twist <= jump.twist


def test_what_can_be_planned_is_given_up_in_nothing():
    jump = Jump(twist=-0.4, forward=0.3, height=0.1)
    found = find_nearest(
        planner_for("anymal", FAR.model).formulation, make_task(jump, ANYMAL), Watch()
    )
    assert found.plain.task.jump == jump
    assert found.plain.solved


def test_multipliers_say_which_limit_is_worth_most():
    """Against the same problem under a limit that is looser by a little."""
    task, found = make_task(FAR, ANYMAL, None, LIMITS), refused_and_found()[1]
    first, loosened = gains(found)[0], 0.01
    looser_task = first.limit.put(task, first.limit.of(task) + loosened)
    begun = found.plain.task.jump, found.plain.solution.variables
    looser = find_nearest(found.formulation, looser_task, Watch(), begun)
    gained = distance(task, found.priced.task.jump) - distance(task, looser.priced.task.jump)
    assert 1 / 3 < gained / (loosened * first.slope) < 3


def test_by_way_of_nearer_jumps_all_of_it_may_be_found(monkeypatch):
    """A twist with everything else, to which no guess leads at once."""
    jump = Jump(twist=-2.0515, forward=0.2595, lateral=0.0304, height=0.0872)
    monkeypatch.setattr(
        "llsrbm.planning.answer.planner.FROM_GUESS_FIRST", replace(FROM_GUESS, iterations=5)
    )
    said = []
    plan = llsrbm.plan(jump, guesses=False, progress=said.append, draft=True)
    assert plan.jump == jump
    assert (plan.report.guess, plan.report.attempts) == (BY_NEARER, 2)
    assert [news.text for news in said if news.iteration is None] == [
        "attempt 1: from the analytic guess",
        "looking for the nearest jump that can be planned",
    ]


def test_turns_have_no_nearer_ones():
    flip = Jump(robot="go2", type="flip", pitch=-2 * math.pi)
    robot = load_robot("go2")
    assert not layout_of(flip, robot).gives
    assert layout_of(Jump(robot="go2"), robot).gives


def test_cancelled_and_bad_input():
    with pytest.raises(Cancelled):
        llsrbm.plan(FAR, limits=LIMITS, cancelled=lambda: True, draft=True)
    with pytest.raises(InputError, match="unknown limit 'force'"):
        llsrbm.plan(FAR, limits={"force": 1.0}, draft=True)


def test_stops_in_words():
    stop = Stop("reach", "flight", 0.62, 0.02, "m", "reach_max", "longest leg", 0.52, 0.54)
    assert str(stop) == "the longest leg would have to be 0.54 m in flight at 0.62 s, it is 0.52"
    assert sentence((stop, stop)) == str(stop)
    held = replace(stop, amount=0.0)
    assert str(held) == "the longest leg is at its limit of 0.52 m"
    assert sentence((held, held, held)) == f"{held} and {held}"
    demand = JointNeed("RH_HAA", 107.2, 34.0, "Nm", "at lift-off")
    assert str(replace(stop, demand=demand)) == "RH_HAA needs 110 Nm at lift-off, it has 34"
    assert str(Stop("momentum_balance", "flight", 0.5, 3.0, "kg m2/s")) == (
        "momentum_balance is violated by 3 kg m2/s in flight at 0.50 s"
    )


@pytest.mark.nightly
def test_what_the_check_agrees_to_in_the_end_is_planned_in_full():
    """What the rows keep of the limits costs it half a degree."""
    jump = Jump(twist=math.radians(84.0), forward=0.54, lateral=-0.07, height=0.15)
    assert llsrbm.plan(jump, guesses=False, explains=False, draft=True).jump == jump
