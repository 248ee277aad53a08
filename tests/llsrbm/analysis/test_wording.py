"""What the page, the command line and files say of plans and rollouts."""

import math
from dataclasses import replace

import numpy as np
import pytest

from llsrbm.analysis.diagnosis import diagnose
from llsrbm.analysis.wording import landing, outcome_words, plan_rows, rollout_rows
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Push, Scenario
from llsrbm.robots import load_robot
from tests.app.synthetic_plan import FLY, GRAVITY, STAND, synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout


@pytest.fixture(scope="module")
def plan():
    return synthetic_plan(Jump(twist=1.0))


@pytest.fixture(scope="module")
def rollout(plan):
    return synthetic_rollout(plan, seed=4)


def changed(rollout, **outcome):
    return replace(rollout, outcome=replace(rollout.outcome, **outcome))


def test_a_plan(plan):
    robot, rows = load_robot("anymal"), dict(plan_rows(plan))
    phases = f"take-off {STAND:.2f} + flight {FLY:.2f} + landing {STAND:.2f}"
    assert rows["Duration"] == f"{2 * STAND + FLY:.2f} s = {phases}"
    assert rows["Turn"] == f"{math.degrees(1):+.1f}°, at most {1 / FLY:.2f} rad/s"
    Izz = f"{robot.inertia[2, 2]:.2f}"
    assert rows["Least yaw inertia Izz"] == f"{Izz} kg m² ({Izz} standing)"
    radius = np.linalg.norm((robot.feet - robot.com)[:, :2], axis=1).mean()
    assert float(rows["Feet radius"].removesuffix(" m")) == pytest.approx(radius, rel=0.02)
    assert rows["Peak power"].endswith(" J back")
    assert rows["Peak foot force"] == f"{robot.mass * GRAVITY / 4:.0f} N, 0.25 weights"
    rear = dict(plan_rows(synthetic_plan(Jump(type="rear-last"))))["Duration"]
    assert "take-off 0.20 + rear push (LH, RH) 0.20 + flight 0.50 + landing 0.40" in rear


def test_what_was_not_found_has_no_figures_of_a_motion(plan):
    failed = replace(plan, report=replace(plan.report, status="not-converged"))
    assert [title for title, _ in plan_rows(failed)] == [
        "Solver",
        "Certificate",
        "Largest violation",
    ]


def test_the_most_loaded_joint(plan):
    torque = plan.joint_torque.copy()
    torque[3, plan.joint_names.index("RH_KFE")] = 34.0
    rows = dict(plan_rows(replace(plan, joint_torque=torque)))
    assert rows["Most loaded joint"] == "RH_KFE 34 of 40 Nm in take-off at 0.09 s (85 %)"
    unknown = replace(plan, joint_torque=None, joint_torque_limit=None)
    assert "Most loaded joint" not in dict(plan_rows(unknown))


@pytest.mark.parametrize(
    ("outcome", "title", "told"),
    [
        ({}, "Touchdown", "detected 0.895 s (+5.0 ms), 0 false"),
        ({"touchdown_detected_s": None}, "Touchdown", "came 0.890 s, not detected, 0 false"),
        ({"touchdown_true_s": None}, "Touchdown", "never came, detected 0.895 s, 0 false"),
        ({"false_touchdowns": 2}, "Touchdown", "2 false"),
        ({"foot_error_at_touchdown": None}, "Place from the plan", "CoM, 13 mm feet at the end"),
        ({"saturated_fraction": 0.0251}, "Drives", "saturated in 2.5 % of the ticks"),
        ({"peak_torque_ratio": 0.98, "peak_speed_ratio": 1.02}, "Drives", "98 % of torque, 102 %"),
        ({"unsolved_ticks": 3}, "Controller", "QP unsolved in 3 of "),
    ],
)
def test_a_rollout(rollout, outcome, title, told):
    assert told in dict(rollout_rows(changed(rollout, **outcome)))[title]


def test_the_world(rollout):
    def world(**scenario):
        return dict(rollout_rows(replace(rollout, scenario=Scenario(**scenario))))

    told = world(board=0.025, half_board=True, seed=4)["World"]
    assert told.startswith("half board of 25 mm, seed 4 with noise 1: trunk +5.0 %, friction 0.70")
    assert "rotors +12.0 %, joint friction 1.4 ×" in told
    assert world()["World"] == "undisturbed"
    assert world(drives="ideal")["World"] == "undisturbed, ideal drives"
    told = world(drives="ideal", seed=4)["World"]
    assert "rotors" not in told
    assert told.endswith("ideal drives")
    assert world(trunk_mass=0.12)["World"] == "undisturbed, trunk +12.0 % of its believed mass"
    pushes = (Push(0.4, (0, 12, 0), (0, 0, -0.5)), Push(0.5, (1, 2, 0)))
    told = world(pushes=pushes)
    assert told["Push 1"] == "0, 12, 0 N s and 0, 0, −0.5 N m s at 0.400 s"
    assert told["Push 2"] == "1, 2, 0 N s at 0.500 s"


def test_a_fall_is_told_event_by_event(plan, rollout):
    fell = synthetic_rollout(plan, fell_at=0.95)
    events = diagnose(fell)[:4]
    told = rollout_rows(fell)[: len(events)]
    assert told == [(f"Wrong from {event.time:.2f} s", event.words) for event in events]
    assert outcome_words(fell).startswith(f"Fell at 0.95 s: first {events[0].words}")
    assert "Wrong" not in str(rollout_rows(rollout)), "of what went well, near misses are not told"


@pytest.mark.parametrize(
    ("outcome", "why"),
    [
        ({"recovered": True, "foot_error": 0.08}, "feet misplaced by 80 mm"),
        (
            {
                "recovered": False,
                "final_tilt": 0.04,
                "touched": "LH_SHANK touched the box at 0.61 s",
            },
            "LH_SHANK touched the box at 0.61 s, tilted by 2.3° at the end",
        ),
        ({"recovered": False, "peak_tilt": 0.3}, "tilted by up to 17.2° after touchdown"),
        ({"recovered": False, "second_flight_s": 0.04}, "bounced for 40 ms"),
        ({"recovered": False, "unsolved_ticks": 1}, "QP unsolved in 1 tick"),
        ({"recovered": False}, "a flight before the last ended on too few feet"),
    ],
)
def test_why_a_landing_is_not_strict(rollout, outcome, why):
    assert landing(rollout.outcome) == "Landed"
    found = changed(rollout, strict=False, **outcome).outcome
    assert landing(found) == f"Landed, not strict: {why}"
