import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from llsrbm.analysis.figure_table import FIGURES
from llsrbm.analysis.figures import DesignFigures, figures_of_plan, figures_of_rollout
from tests.llsrbm.synthetic import FLIGHT, GRAVITY, TWO_HOPS, TWO_HOPS_DURATIONS, synthetic_plan
from tests.llsrbm.synthetic_rollout import (
    EARLY_TICKS,
    RATE,
    YAW_SHORTFALL,
    followed,
    synthetic_rollout,
)

FIGURE = {figure.name: figure for figure in FIGURES}
ROW = DesignFigures(
    "planned", 1.3, 0.4, 0.2, 1.5, 1.9, 0.24, 1.2, 230.0, 0.7, None, None, None, 0.12
)


@pytest.fixture(scope="module")
def plan():
    return synthetic_plan(durations=(0.5, 0.4, 0.6))


@pytest.fixture(scope="module")
def rollout(plan):
    return synthetic_rollout(plan)


def test_a_plans_figures(plan):
    figures = figures_of_plan(plan)
    assert (figures.status, figures.valid) == ("planned", True)
    assert figures.flight_time_s == pytest.approx(0.4)
    # The yaw is a cubic in time, whose rate is largest in the middle of the motion.
    assert figures.peak_yaw_rate == pytest.approx(1.5 * 1.57 / 1.5, rel=0.01)
    radii = [
        sum(math.hypot(*(foot - com)[:2]) for foot in feet) / 4
        for phase, com, feet in zip(plan.phase, plan.com, plan.foot_position)
        if phase == FLIGHT
    ]
    assert figures.feet_radius == pytest.approx(min(radii))
    # About the vertical: the trunk's, and legs of 2 kg half way to the feet.
    lever = [
        sum(2.0 * ((c - com)[:2] @ (c - com)[:2]) for c in legs)
        for phase, com, legs in zip(plan.phase, plan.com, plan.leg_com)
        if phase == FLIGHT
    ]
    assert figures.smallest_Izz == pytest.approx(2.2 + min(lever))
    standing = plan.inertia[0, 2, 2]
    assert figures.Izz_change == pytest.approx((2.2 + np.mean(lever)) / standing - 1)
    assert figures.peak_force == max(math.hypot(*f) for f in plan.contact_force.reshape(-1, 3))
    assert figures.peak_force_in_weights == pytest.approx(figures.peak_force / 30 / 9.81)
    shares = np.abs(plan.joint_torque[:-1]) / plan.joint_torque_limit[:-1]
    assert figures.planned_torque_ratio == shares.max() < 0.75
    assert figures.solve_time_s == 0.08
    assert figures.peak_torque_ratio is figures.yaw_error_at_touchdown is None


def test_flights_of_several_jumps_add_up():
    plan = synthetic_plan(schedule=TWO_HOPS, durations=TWO_HOPS_DURATIONS)
    assert figures_of_plan(plan).flight_time_s == pytest.approx(0.3 + 0.35)
    figures = figures_of_rollout(followed(plan))
    assert figures.flight_time_s == pytest.approx(0.3 + 0.35 - 2 * EARLY_TICKS / RATE)


@pytest.mark.parametrize(("axis", "turns"), [("y", -1), ("y", 1), ("x", 1), ("x", -2)])
def test_a_flip_is_no_yaw(plan, axis, turns):
    rate = np.zeros((len(plan.time), 3))
    rate[:, "xy".index(axis)] = turns * math.tau / plan.time[-1]
    flip = Rotation.from_rotvec(rate * plan.time[:, None]).as_quat(scalar_first=True)
    tumbling = replace(plan, base_quat=flip, angular_velocity=rate)
    assert figures_of_plan(tumbling).final_yaw == pytest.approx(0.0, abs=1e-9)


def test_a_simulation_adds_how_it_went(plan, rollout):
    alone, both = figures_of_plan(plan), figures_of_plan(plan, rollout)
    assert both == replace(
        alone, status="landed", peak_torque_ratio=0.75, yaw_error_at_touchdown=-YAW_SHORTFALL
    )
    assert figures_of_plan(plan, synthetic_rollout(plan, fell_at=1.0)).status == "fell"


def test_a_rollouts_own_figures(plan, rollout):
    figures = figures_of_rollout(rollout)
    assert (figures.status, figures.solve_time_s) == ("landed", None)
    assert figures.planned_torque_ratio is None
    assert figures.flight_time_s == pytest.approx(0.4 - EARLY_TICKS / RATE)
    heading = 2 * np.arctan2(rollout.base_quat[:, 3], rollout.base_quat[:, 0])
    rate = np.gradient(np.unwrap(heading), rollout.time)
    assert figures.peak_yaw_rate == pytest.approx(np.abs(rate).max(), rel=1e-3)
    force = max(math.hypot(*f) for f in rollout.contact_force.reshape(-1, 3))
    assert figures.peak_force == pytest.approx(force)
    assert figures.peak_force_in_weights == pytest.approx(force / (30 * np.linalg.norm(GRAVITY)))
    flying = rollout.contact.sum(axis=1) == 0
    assert figures.smallest_Izz == pytest.approx(rollout.inertia[flying, 2, 2].min())
    assert figures.yaw_error_at_touchdown == -YAW_SHORTFALL


def test_the_yaw_rate_of_a_tilted_base_is_about_the_worlds_vertical(rollout):
    """On its side, a base that turns about its own x axis turns about the vertical."""
    side = np.tile([math.sqrt(0.5), 0, -math.sqrt(0.5), 0], (len(rollout.time), 1))
    qvel = np.zeros_like(rollout.qvel)
    qvel[:, 3:5] = 2.5, 9.0
    assert figures_of_rollout(replace(rollout, base_quat=side, qvel=qvel)).peak_yaw_rate == (
        pytest.approx(2.5)
    )


def test_what_a_fall_cuts_off_is_not_counted(plan):
    rollout = synthetic_rollout(plan)
    force = rollout.contact_force.copy()
    force[rollout.time > 1.2] *= 100
    fell = replace(
        rollout,
        contact_force=force,
        outcome=replace(rollout.outcome, status="fell", fell_at_s=1.19),
    )
    assert figures_of_rollout(fell).peak_force <= figures_of_rollout(rollout).peak_force


def test_a_touchdown_within_a_tick_counts_from_when_it_is(rollout):
    """Which then shows contact, though it began without."""
    contact = rollout.contact.copy()
    touchdown = 0.9 - EARLY_TICKS / RATE
    contact[round(touchdown * RATE) - 1] = 1
    within = replace(
        rollout,
        contact=contact,
        outcome=replace(rollout.outcome, touchdown_true_s=touchdown - 0.001),
    )
    figures = figures_of_rollout(within)
    assert figures.flight_time_s == pytest.approx(0.4 - EARLY_TICKS / RATE - 0.001)
    assert figures.smallest_Izz is not None


@pytest.mark.parametrize(
    ("name", "value", "shown"),
    [
        ("flight_time_s", 0.41234, "0.412"),
        ("peak_torque_ratio", 0.984, "98"),
        ("peak_torque_ratio", None, "–"),
        ("planned_torque_ratio", 0.851, "85"),
        ("solve_time_s", 0.0876, "88"),
        ("yaw_error_at_touchdown", math.radians(2.04), "+2.0"),
        ("yaw_error_at_touchdown", math.radians(-0.01), "0.0"),
        ("peak_yaw_rate", math.inf, "–"),
    ],
)
def test_values_are_shown_in_their_unit(name, value, shown):
    assert FIGURE[name].shown(replace(ROW, **{name: value})) == shown


def best(name, *values, status="landed"):
    return FIGURE[name].best([replace(ROW, status=status, **{name: value}) for value in values])


def test_the_best():
    assert best("solve_time_s", 0.2, None, 0.1) == {2}
    assert best("yaw_error_in_flight", -0.1, 0.02, 0.05) == {1}
    assert best("peak_force", 230.3, 230.1, 240.0) == {0, 1}, "what is shown alike is as good"
    assert best("peak_force", 230.3, 230.1) == set()
    assert best("peak_force", 230.3) == set()
    assert best("flight_time_s", 0.3, 0.5) == set(), "neither is better"
