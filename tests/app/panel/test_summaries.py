import math
import re
from dataclasses import replace
from html import escape

import numpy as np
import pytest

from app.panel.status import Status, Verdict
from app.panel.summaries import (
    drive_figures,
    plan_figures,
    plan_status,
    refused_status,
    rollout_figures,
    simulated_status,
)
from llsrbm.analysis.diagnosis import diagnose
from llsrbm.analysis.wording import drive_rows
from llsrbm.certificate import Certificate, Finding
from llsrbm.motion.solve_report import Refinement
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Push, Scenario
from llsrbm.robots import load_robot
from llsrbm.robots.drives.table import JointDrives, Losses
from tests.app.synthetic_plan import FLY, refined_plan, synthetic_plan
from tests.app.synthetic_replans import with_replans
from tests.llsrbm.synthetic_rollout import synthetic_rollout

KNOTS_ONLY = "its drives were looked at in knots only"


@pytest.fixture(scope="module")
def plan():
    return synthetic_plan(Jump(twist=1.0))


@pytest.fixture(scope="module")
def rollout(plan):
    return synthetic_rollout(plan, seed=4)


def changed(rollout, **outcome):
    return replace(rollout, outcome=replace(rollout.outcome, **outcome))


def test_a_solver_that_is_being_compiled_is_said_to_be(plan):
    slow = replace(plan, report=replace(plan.report, compiling=True))
    assert "still being compiled" in plan_figures(slow)
    assert "compiled" not in plan_figures(plan)
    assert "compiled" not in plan_status(slow).rest  # which stays when it has been


def test_a_plan_is_told_by_inertia_flight_torque_and_what_its_model_leaves_out(plan):
    flies = ~plan.contact.any(axis=1)
    shaped = np.where(flies[:, None, None], 0.9, 1.0) * plan.inertia
    status = plan_status(replace(plan, inertia=shaped), "from file a.npz")
    assert (status.verdict, status.rest) == ("Draft", f"from file a.npz, as {KNOTS_ONLY}")
    (inertia, flight, torque, turn) = status.figures
    assert inertia == ("Yaw inertia Izz, flight", "−10 %")
    assert flight == ("Flight time", f"{FLY:.3f} s")
    assert re.fullmatch(r"\d+ %", torque[1])
    assert (turn[0], turn[1][-1]) == ("Model's turn error", "°")
    assert re.sub(r"<[^>]*>", "", status.html).startswith(
        f"Draft from file a.npz, as {KNOTS_ONLY} Yaw inertia Izz, flight "
    )


def test_a_flip_is_told_by_its_turn():
    flip = synthetic_plan(Jump(robot="go2", type="flip", pitch=-math.tau))
    flip = replace(flip, angular_velocity=np.zeros_like(flip.com))
    flip.angular_velocity[:, 1] = -math.tau / flip.duration
    assert plan_status(flip).figures[0] == ("Turn", "−360.0°")


def test_figures_of_the_motion_before_are_marked_and_all_that_is_awaited_is_amber(plan):
    status = replace(plan_status(plan), busy=True, old=True)
    assert '<dl class="old"' in status.html
    assert 'class="old"' not in plan_status(plan).html
    colours = {
        re.search(r"--verdict:(#\w+)", replace(status, verdict=verdict).html)[1]
        for verdict in Verdict
    }
    assert len(colours) == 1


def test_checks_that_hold_are_counted(plan):
    broken = Finding("slip", 0.02, 0.01, "m", "RL", 0.3, False, 0.01)
    held = Finding("friction", 0.2, 0.5, "", "RL", 0.3, True, 0.5)
    whole = refined_plan(plan)
    half = replace(whole, certificate=Certificate((broken, held)).as_dict())
    assert ">1/1 checks<" in plan_status(whole).html
    assert ">1/2 checks<" in plan_status(half).html
    assert "llsrbm-checks" not in plan_status(plan).html


def test_a_plan_is_feasible_and_green_over_a_certificate_that_holds_alone(plan):
    whole = refined_plan(plan)
    slipping = Certificate((Finding("slip", 0.02, 0.01, "m", "RL", 0.3, False, 0.01),))
    unknown = Certificate((Finding("battery_current", None, None, "A", "", None, None),))
    drafts = {
        KNOTS_ONLY: plan,
        "the whole body's plan was not found": refined_plan(plan, "not-converged"),
        "it was not checked": replace(whole, certificate=None),
        "its certificate does not hold: slip": replace(whole, certificate=slipping.as_dict()),
        "its certificate does not know: battery current": replace(
            whole, certificate=unknown.as_dict()
        ),
    }
    for reason, each in drafts.items():
        assert (plan_status(each).verdict, plan_status(each).rest) == ("Draft", f"as {reason}")
    assert (plan_status(whole).verdict, plan_status(whole).rest) == ("Feasible", "")
    green, amber = (
        re.search(r"--verdict:(#\w+)", plan_status(each).html)[1] for each in (whole, plan)
    )
    nearest = plan_status(plan, wanted=replace(plan.jump, twist=1.0), reason="so")
    assert amber == re.search(r"--verdict:(#\w+)", nearest.html)[1] != green


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
    figures = [("Yaw error", "−2.9°"), ("Tilt", "0.1°"), ("Foot error", "13 mm")]
    assert status.figures == (*figures, ("Peak torque", "75 %"))


def test_a_landing_that_is_not_strict_says_so(rollout):
    status = simulated_status(changed(rollout, strict=False, foot_error=0.08), "seed 3")
    shown = "Landed, not strict</button></b> <span>seed 3, feet misplaced by 80 mm</span>"
    assert shown in status.html


def test_a_push_that_was_recovered_from_is_no_failure(rollout):
    pushed = changed(rollout, strict=False, recovered=True)
    assert simulated_status(pushed).limit == "not strict"
    pushed = replace(pushed, scenario=Scenario(pushes=(Push(0.5, (3.0, 4.0, 0.0)),)))
    assert simulated_status(pushed).limit == "recovered from the push"


def test_new_plans_are_counted(plan, rollout):
    replanned = with_replans(rollout, plan)
    known = changed(replanned, replan_median_s=0.0101, replan_p95_s=0.0312)
    taken, made = sum(r.applied > 0 for r in known.replans), len(known.replans)
    assert 0 < taken < made
    assert simulated_status(known).rest == f"{taken} of {made} new plans followed"
    assert f"{taken} of {made} followed, 10.1 ms, p95 31.2 ms<" in rollout_figures(known)
    assert "New plans" not in rollout_figures(rollout)


def test_drives_are_told_with_how_they_are_known():
    robot = load_robot("g1")
    losses = Losses(armature=0.0036, friction=0.6)
    drives = JointDrives(armature=0.01, arms=losses, delay=2e-3, known={"armature": "published"})
    robot = replace(robot, file=robot.file.model_copy(update={"drives": drives}))
    html = drive_figures(robot)
    assert "Drives of Unitree G1" in html
    rows = dict(drive_rows(robot))
    assert rows["Rotors"] == "0.01, 0.01, 0.01, 0.01, 0.01, 0.01 kg m², published"
    assert rows["Arms' rotors"] == "0.0036, 0.0036, 0.0036, 0.0036 kg m², published"
    assert rows["Arms' friction"] == "0.6, 0.6, 0.6, 0.6 Nm, assumed"
    assert rows["Delay"] == "2 ms, assumed"
    for title in rows:
        assert escape(title) in html


def test_fell_says_when_and_why(plan):
    rollout = synthetic_rollout(plan, fell_at=0.95)
    first = diagnose(rollout)[0]
    status = simulated_status(rollout)
    assert status.verdict == "Fell"
    assert status.rest == (
        f"at 0.95 s: first {first.words} ({first.time:.2f} s), "
        "then the base touched the ground at 0.95 s."
    )


def test_what_takes_a_known_time_has_a_bar_that_fills_in_it():
    building = Status(Verdict.PLANNING, "(building) ...", busy=True, lasts=30.0).html
    assert 'class="lasts" style="animation-duration:30s"' in building
    assert "progressbar" not in Status(Verdict.FEASIBLE, lasts=30.0).html
    half = Status(Verdict.SIMULATING, busy=True, share=0.5, lasts=30.0).html
    assert 'style="width:50%"' in half


@pytest.mark.parametrize(
    ("status", "said"), [("not-tried", "lands on all feet"), ("not-converged", "was not found")]
)
def test_why_a_flip_stays_a_draft(status, said):
    plan = synthetic_plan(Jump(robot="go2", type="flip", pitch=-math.tau))
    report = Refinement(status, 0, 0.0, 0.0, 0.0, 0.0, compiling=False)
    assert said in plan_status(replace(plan, refinement=report)).rest
