"""What stops a jump, and the nearest that works, judged by plans of their own."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import llsrbm
from llsrbm.errors import Cancelled, InputError, NotConverged, Stop
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.violations import TOLERANCE
from llsrbm.planning.solve.explanation import explain, in_words
from llsrbm.planning.solve.nearest import STEPS, Way
from llsrbm.planning.solve.planner import planner_for
from llsrbm.planning.solve.search import FeasibilitySearch
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot

ANYMAL = load_robot("anymal")

# ---- ways to ask for less


@settings(max_examples=100, deadline=None)
@given(
    twist=st.floats(-3.1, 3.1),
    forward=st.floats(-0.3, 0.6),
    reduced=st.sampled_from([("twist",), ("forward",), ("twist", "forward")]),
    share=st.floats(0, 1),
)
def test_steps_of_a_way_are_round_and_between_nothing_and_the_request(
    twist, forward, reduced, share
):
    jump = Jump(twist=twist, forward=forward)
    way = Way(jump, reduced)
    step = int(share * way.steps)
    less = way.at(step)
    for name in STEPS:
        value, whole = getattr(less, name), getattr(jump, name)
        if name not in reduced or step == way.steps:
            assert value == whole
            continue
        assert abs(value) <= abs(whole) + 1e-9
        assert value * whole >= 0
        assert value / STEPS[name] == pytest.approx(round(value / STEPS[name]), abs=1e-6)
    assert way.at(0) == replace(jump, **dict.fromkeys(reduced, 0.0)) or way.steps == 0


# ---- the nearest


LIMITS = {"torque_share": 0.4}
HIGH = Jump(height=0.3)  # its torques are too small for it


@cache
def found():
    said = []
    return llsrbm.nearest(HIGH, limits=LIMITS, progress=said.append), said


def test_it_is_a_plan_of_a_round_request():
    nearest, said = found()
    plan, height = nearest.plan, nearest.jump.height
    assert plan.solved
    assert plan.jump == nearest.jump
    assert plan.tuning.limits == LIMITS
    assert max(v.amount for v in plan.violations.values()) <= TOLERANCE
    assert np.abs(plan.joint_torque[:-1]).max() <= (0.4 + 0.1) * 40.0 + TOLERANCE
    # Where it ends, from its arrays alone.
    assert plan.foot_position[-1, :, 2] - plan.foot_position[0, :, 2] == pytest.approx(
        np.full(4, height), abs=1e-4
    )
    assert 0.02 < height < 0.3
    assert height * 100 == pytest.approx(round(height * 100), abs=1e-9)
    assert nearest.changes == f"height {height:.3g} m instead of 0.3 m"
    assert len(said) == plan.report.attempts > 3


def test_a_little_more_cannot_be_planned():
    """By the planner itself, which tries longer and from elsewhere; 6 cm, as it is patient."""
    nearest, _ = found()
    more = replace(HIGH, height=nearest.jump.height + 0.06)
    with pytest.raises(NotConverged):
        planner_for("anymal", HIGH.model).plan(more, limits=LIMITS, patient=False)


def test_what_can_be_planned_is_the_nearest():
    nearest = llsrbm.nearest(Jump(model="srbm", twist=0.512))
    assert (nearest.jump.twist, nearest.changes) == (0.512, "")


@pytest.mark.parametrize(
    ("asked", "given", "changes"),
    [
        (
            Jump(twist=0.3, lateral=-0.7),
            Jump(twist=0.3, lateral=-0.3),
            "lateral -0.3 m instead of -0.7 m",
        ),
        (
            Jump(twist=0.5, forward=9.0),
            Jump(twist=0.5, forward=0.6),
            "forward 0.6 m instead of 9 m",
        ),
    ],
)
def test_a_request_out_of_range_is_taken_back_to_it(asked, given, changes):
    nearest = llsrbm.nearest(asked)
    assert (nearest.jump, nearest.changes) == (given, changes)


def test_cancelled_and_bad_input():
    with pytest.raises(Cancelled):
        llsrbm.nearest(HIGH, limits=LIMITS, cancelled=lambda: True)
    with pytest.raises(InputError, match="unknown limit 'force'"):
        llsrbm.nearest(HIGH, limits={"force": 1.0})


# ---- what stops a jump


def test_the_named_limit_is_the_one():
    """Only that limit changed, as it says, makes the jump plannable; half of that does not."""
    planner = planner_for("anymal", HIGH.model)
    task = make_task(HIGH, ANYMAL, None, {"torque_share": 0.44, "friction": 0.45})
    (stop,) = explain(FeasibilitySearch(planner.formulation), task)
    assert (stop.constraint, stop.limit, stop.value) == ("joint_torque", "torque_share", 0.44)
    assert 0.44 < stop.needed < ANYMAL.file.limits.torque_share
    assert stop.amount == pytest.approx(stop.needed - 0.44)
    assert stop.phase == "take-off"
    assert planner.plan(HIGH, limits={"torque_share": stop.needed, "friction": 0.45}).solved
    half = {"torque_share": 0.44 + 0.5 * stop.amount, "friction": 0.45}
    with pytest.raises(NotConverged):
        planner.plan(HIGH, limits=half, patient=False)


def test_stops_in_words():
    stop = Stop("reach", "flight", 0.62, 0.02, "m", "reach_max", "longest leg", 0.52, 0.54)
    assert str(stop) == (
        "longest leg (reach_max) would have to be 0.54 m in flight at 0.62 s; the limit is 0.52 m"
    )
    assert in_words((stop, stop)) == f"{stop} or {stop}"
    both = replace(stop, together=True)
    assert in_words((both, both)) == f"{stop} and {stop}"
    assert str(Stop("momentum_balance", "flight", 0.5, 3.0, "kg m2/s")) == (
        "momentum_balance is violated by 3 kg m2/s in flight at 0.50 s"
    )
