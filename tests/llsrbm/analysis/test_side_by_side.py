"""One jump made in several ways, in a sentence: checked against the figures of `llsrbm compare`."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from llsrbm.analysis.figures import figures_of_plan
from llsrbm.analysis.side_by_side import Way, axis_of, rows, sentence, turning
from llsrbm.request.jump import Jump
from tests.app.synthetic_plan import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout


def rollout(twist=1.0, *, off=-0.06, in_flight=-0.14, fell_at=None, inertia=(1.0, 1.0), **asked):
    """A simulation that was so far off in yaw, of a plan whose Izz changes by factors in flight."""
    plan = synthetic_plan(Jump(robot="anymal", twist=twist, **asked))
    factor = np.ones(len(plan.time))
    flight = np.flatnonzero(plan.phase == 1)
    factor[flight] = np.linspace(*inertia, len(flight))
    plan = replace(plan, inertia=plan.inertia * factor[:, None, None])
    run = synthetic_rollout(plan, fell_at=fell_at)
    sense = math.copysign(1.0, twist)
    turns = {"yaw_error_at_touchdown": sense * off, "yaw_error_in_flight": sense * in_flight}
    return replace(run, outcome=replace(run.outcome, **turns))


def test_each_way_has_its_turn_and_its_inertia_and_the_best_is_named():
    held, drawn_in = rollout(), rollout(off=-0.02, in_flight=0.01, inertia=(0.96, 0.9))
    standing = held.plan.inertia[0, 2, 2]
    text = sentence([Way("SRBM", held), Way("LL-SRBM", drawn_in)])
    assert text == (
        "At touchdown SRBM has turned 3.4° less than planned (8.0° lost in flight, Izz held at "
        f"{standing:.2f} kg m²); LL-SRBM 1.1° less (0.6° gained, Izz "
        f"{0.96 * standing:.2f} → {0.9 * standing:.2f}): LL-SRBM foresees the flight best."
    )


REQUESTS = [
    {"twist": angle, "off": off, "in_flight": flown, "forward": forward}
    for angle, off, flown, forward in (
        (1.57, -0.06, -0.14, 0.0), (-0.8, 0.05, 0.1, 0.2), (3.14, 0.19, 0.11, 0.0),
        (0.5, 0.0, 0.0, 0.0), (-3.14, -0.26, -0.29, 0.3),
    )
]  # fmt: skip


@pytest.mark.parametrize("asked", REQUESTS)
def test_its_figures_are_those_of_the_comparison(asked):
    run = rollout(**asked)
    figures = figures_of_plan(run.plan, run)
    text = sentence([Way("SRBM", run)])
    sense = math.copysign(1.0, asked["twist"])
    at_touchdown, how = re.search(r"turned ([\d.]+)° (less|more) than planned", text).groups()
    signed = {"less": -1, "more": 1}[how] * float(at_touchdown)
    assert signed == pytest.approx(sense * math.degrees(figures.yaw_error_at_touchdown), abs=0.0501)
    flown, lost = re.search(r"\(([\d.]+)° (lost )?", text).groups()
    assert float(flown) * (-1 if lost else 1) == pytest.approx(
        sense * math.degrees(figures.yaw_error_in_flight), abs=0.0501
    )
    held = float(re.search(r"Izz held at ([\d.]+)", text).group(1))
    assert held == pytest.approx(figures.smallest_Izz, abs=0.00501)


def test_of_a_jump_without_a_turn_it_is_the_pitch():
    run = rollout(twist=0.0, forward=0.3)
    # The base as planned, but for 5° of pitch from mid-flight on, about its own lateral axis.
    tracked = Rotation.from_quat(run.reference_base_quat, scalar_first=True)
    off = Rotation.from_rotvec(np.outer(run.time > 0.6, [0.0, np.radians(5.0), 0.0]))
    run = replace(run, base_quat=(tracked * off).as_quat(scalar_first=True))
    turn = turning(run)
    assert turn.axis == "pitch"
    assert not turn.requested
    assert math.degrees(turn.off) == pytest.approx(5.0, abs=0.01)
    assert math.degrees(turn.in_flight) == pytest.approx(5.0, abs=0.01)
    text = sentence([Way("SRBM", run), Way("LL-SRBM", run)])
    assert text.startswith("At touchdown SRBM is 5.0° off its plan in pitch (5.0° in flight, Iyy ")
    assert text.endswith(": all foresee the flight alike.")


@pytest.mark.parametrize(
    ("asked", "axis"),
    [
        ({"twist": -0.1, "forward": 0.4}, "yaw"),
        ({"forward": 0.4}, "pitch"),
        ({"lateral": -0.2, "forward": 0.1}, "roll"),
        ({"type": "flip", "pitch": -math.tau}, "pitch"),
        ({}, "pitch"),
    ],
)
def test_the_axis_is_the_requests(asked, axis):
    assert axis_of(Jump(**asked)) == axis


def test_what_has_no_plan_or_falls_is_said():
    early = rollout(fell_at=0.5)
    early = replace(early, outcome=replace(early.outcome, yaw_error_at_touchdown=None))
    ways = [
        Way("SRBM", why_not="LF_KFE needs 18 rad/s at touchdown, it has 15"),
        Way("LL-SRBM", early),
        Way("LL-SRBM+", rollout(fell_at=1.4)),
    ]
    text = sentence(ways)
    first, second, third = text.removesuffix(".").split("; ")
    assert first == "SRBM has no plan (LF_KFE needs 18 rad/s at touchdown, it has 15)"
    assert second == "LL-SRBM falls at 0.50 s and does not touch down on its feet"
    assert third.startswith("at touchdown LL-SRBM+ has turned 3.4° less than planned (")
    assert "), and falls at 1.40 s" in third
    assert dict(rows(ways))["Outcome"] == ("no plan", "fell", "fell")


def test_of_scenarios_it_is_the_feet_that_count():
    ways = [Way("Ideal drives", rollout(off=0.0)), Way("True drives", rollout())]
    assert sentence(ways, of_models=False) == (
        "At touchdown the robot has turned 0.0° more than planned with ideal drives (feet 13 mm "
        "off at the end); 3.4° less with true drives (feet 13 mm off at the end)."
    )
    ways = [Way("Without replanning", rollout(fell_at=1.4)), Way("Held arms", why_not="too fast")]
    assert sentence(ways, of_models=False).endswith(
        "than planned without replanning (feet 13 mm off at the end), and falls at 1.40 s; "
        "the robot has no plan with held arms (too fast)."
    )


def test_figures_are_rows_with_a_text_a_way():
    ways = [Way("SRBM", rollout()), Way("LL-SRBM", why_not="no")]
    table = dict(rows(ways))
    assert table["Yaw beyond the plan in flight [°]"] == ("−8.0", "–")
    assert table["Yaw beyond the plan at touchdown [°]"] == ("−3.4", "–")
    assert table["Feet off the plan at the end [mm]"] == ("13", "–")
    assert table["Outcome"] == ("landed", "no plan")
