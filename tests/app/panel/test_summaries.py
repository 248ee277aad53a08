from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from app.panel.summaries import (
    plan_figures,
    plan_status,
    refused_status,
    rollout_figures,
    simulated_status,
)
from llsrbm.analysis.diagnosis import diagnose
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Push, Scenario
from llsrbm.robots import load_robot
from tests.app.synthetic_plan import FLY, GRAVITY, STAND, synthetic_plan
from tests.app.synthetic_replans import with_replans
from tests.llsrbm.synthetic_rollout import synthetic_rollout


@pytest.fixture(scope="module")
def plan():
    return synthetic_plan(Jump(twist=1.0))


@pytest.fixture(scope="module")
def rollout(plan):
    return synthetic_rollout(plan, seed=4)


def changed(rollout, **outcome):
    return replace(rollout, outcome=replace(rollout.outcome, **outcome))


def test_the_most_loaded_joint_of_a_plan(plan):
    torque = plan.joint_torque.copy()
    torque[3, plan.joint_names.index("RH_KFE")] = 34.0
    shown = plan_figures(replace(plan, joint_torque=torque))
    assert "Most loaded joint" in shown
    assert "RH_KFE 34 of 40 Nm in take-off at 0.09 s (85 %)" in shown
    unknown = replace(plan, joint_torque=None, joint_torque_limit=None)
    assert "Most loaded joint" not in plan_figures(unknown)


def test_a_phase_in_which_some_feet_stand_names_them():
    rear = plan_figures(synthetic_plan(Jump(type="rear-last")))
    assert "take-off 0.20 + rear push (LH, RH) 0.20 + flight 0.50 + landing 0.40" in rear


def test_a_solver_that_is_being_compiled_is_said_to_be(plan):
    slow = replace(plan, report=replace(plan.report, compiling=True))
    assert "still being compiled" in plan_status(slow).rest
    assert "still being compiled" in plan_figures(slow)
    assert "compiled" not in plan_status(plan).rest + plan_figures(plan)


def test_a_plan_is_told_by_flight_apex_and_torque(plan):
    status = plan_status(plan, "from file a.npz")
    assert (status.verdict, status.rest) == ("Feasible", "from file a.npz")
    (flight, apex, torque) = status.figures
    assert flight == ("Flight", f"{FLY:.2f} s")
    assert re.fullmatch(r"\+?\d+ cm", apex[1])
    assert re.fullmatch(r"\d+ %", torque[1])
    assert re.sub(r"<[^>]*>", "", status.html).startswith("Feasible from file a.npz Flight 0.")


def test_a_refusal_is_told_by_the_nearest_and_the_reason(plan):
    wanted = replace(plan.jump, twist=math.radians(170))
    status = plan_status(plan, wanted=wanted, reason="RH_HAA needs 107 Nm, it has 34")
    assert status.verdict == "Nearest"
    assert status.points == ("57.3° instead of 170°.", "RH_HAA needs 107 Nm, it has 34.")
    assert "<li>RH_HAA needs 107 Nm, it has 34.</li>" in status.html
    assert refused_status("no way").verdict == "Infeasible"


def test_landed(rollout):
    status = simulated_status(rollout)
    assert (status.verdict, status.limit, status.rest) == ("Landed", "", "")
    assert status.figures == (("Yaw error", "−2.9°"), ("Tilt", "0.1°"), ("Foot error", "13 mm"))


def test_a_landing_that_is_not_strict_says_so(rollout):
    status = simulated_status(changed(rollout, strict=False), "seed 3")
    assert "Landed, not strict</button></b> <span>seed 3</span>" in status.html


def test_a_push_that_was_recovered_from_is_no_failure(rollout):
    pushed = changed(rollout, strict=False, recovered=True)
    assert simulated_status(pushed).limit == "not strict"
    pushed = replace(pushed, scenario=Scenario(pushes=(Push(0.5, (3.0, 4.0, 0.0)),)))
    assert simulated_status(pushed).limit == "recovered from the push"
    assert "push of 5.0 N s at 0.50 s" in rollout_figures(pushed)


def test_new_plans_are_counted(plan, rollout):
    replanned = with_replans(rollout, plan)
    known = changed(replanned, replan_median_s=0.0101, replan_p95_s=0.0312)
    taken, made = sum(r.applied > 0 for r in known.replans), len(known.replans)
    assert 0 < taken < made
    assert simulated_status(known).rest == f"{taken} of {made} new plans followed"
    assert f">{taken} of {made} followed<" in rollout_figures(known)
    assert "10.1 ms, p95 31.2 ms" in rollout_figures(known)
    assert "New plans" not in rollout_figures(rollout)


def test_unsolved_ticks_are_told(rollout):
    rest = simulated_status(changed(rollout, strict=False, unsolved_ticks=3)).rest
    assert rest.endswith("the controller's QP was unsolved in 3 ticks")


def test_fell_says_when_and_why(plan):
    rollout = synthetic_rollout(plan, fell_at=0.95)
    first = diagnose(rollout)[0]
    status = simulated_status(rollout)
    assert status.verdict == "Fell"
    assert status.rest == (
        f"at 0.95 s: first {first.words} ({first.time:.2f} s), "
        "then the base touched the ground at 0.95 s."
    )


@pytest.mark.parametrize(
    ("outcome", "told"),
    [
        ({}, "+5.0 ms from the first contact"),
        ({"touchdown_detected_s": None}, "missed"),
        ({"touchdown_true_s": None, "touchdown_detected_s": None}, "no contact, none detected"),
        ({"false_touchdowns": 2}, "+5.0 ms from the first contact, 2 false"),
        ({"foot_error_at_touchdown": None}, "none at touchdown, 13 mm at the end"),
        ({"saturated_fraction": 0.0251}, "2.5 %"),
        ({"peak_torque_ratio": 0.98, "peak_speed_ratio": 1.02}, "98 % of torque, 102 % of speed"),
    ],
)
def test_figures(rollout, outcome, told):
    assert f">{told}<" in rollout_figures(changed(rollout, **outcome))


def test_a_fall_is_told_event_by_event(plan, rollout):
    fell = synthetic_rollout(plan, fell_at=0.95)
    html = rollout_figures(fell)
    places = [html.index(f">{event.words}<") for event in diagnose(fell)[:4]]
    assert places == sorted(places)
    assert f">Wrong from {diagnose(fell)[0].time:.2f} s<" in html
    assert "Wrong" not in rollout_figures(rollout), "of what went well, near misses are not told"


def test_a_plans_figures(plan):
    robot = load_robot("anymal")
    html = plan_figures(plan)
    phases = f"take-off {STAND:.2f} + flight {FLY:.2f} + landing {STAND:.2f}"
    assert f">{2 * STAND + FLY:.2f} s = {phases}<" in html
    assert f">{1.0 / FLY:.2f} rad/s<" in html
    Izz = f"{robot.inertia[2, 2]:.2f}"
    assert f">{Izz} kg m² ({Izz} standing)<" in html
    radius = np.linalg.norm((robot.feet - robot.com)[:, :2], axis=1).mean()
    assert float(html.split("Minimum foot radius</th>")[1].split(">")[1].split()[0]) == (
        pytest.approx(radius, rel=0.02)
    )
    assert f">{robot.mass * GRAVITY / 4:.0f} N, 0.25 of the weight<" in html


def test_the_world_is_told(rollout):
    world = rollout_figures(
        replace(rollout, scenario=Scenario(board=0.025, half_board=True, seed=4))
    )
    assert "half board of 25 mm, seed 4: trunk +5.0 %, friction 0.70" in world
    assert "undisturbed" in rollout_figures(replace(rollout, scenario=Scenario()))
    heavier = replace(rollout, scenario=Scenario(trunk_mass=0.12))
    assert ">trunk +12.0 %<" in rollout_figures(heavier)
