from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from app.plots import COM_HEIGHT, DETECTION, FORCE, NORM, TITLES, YAW, YAW_RATE, curves
from app.replay import bake
from llsrbm.jump import Jump
from llsrbm.robots import load_robot
from tests.app.synthetic_plan import FLY, GRAVITY, STAND, synthetic_plan
from tests.llsrbm.synthetic_rollout import THRESHOLD, synthetic_rollout


@pytest.fixture(scope="module")
def robot():
    return load_robot("anymal")


@pytest.fixture(scope="module")
def planned(robot):
    return bake(synthetic_plan(Jump(twist=2.5)), robot)


@pytest.fixture(scope="module")
def rollout(planned):
    return synthetic_rollout(planned.plan)


@pytest.fixture(scope="module")
def pairs(planned, rollout):
    return curves(planned, rollout)


def at(curve, instant):
    return np.interp(instant, curve.time, curve.values)


def test_a_plan_alone_is_plotted_alone(planned):
    pairs = curves(planned, None)
    assert list(pairs) == list(TITLES[:-1])
    assert all(simulated is None for _, simulated in pairs.values())


def test_planned_curves_in_mid_flight(planned, pairs, robot):
    middle = STAND + FLY / 2
    height = robot.com[2] + GRAVITY * FLY**2 / 8
    assert at(pairs[YAW][0], middle) == pytest.approx(np.degrees(1.25), abs=0.5)
    assert at(pairs[YAW_RATE][0], middle) == pytest.approx(2.5 / FLY)
    assert at(pairs[COM_HEIGHT][0], middle) == pytest.approx(height, abs=1e-3)
    assert at(pairs[FORCE][0], middle) == 0
    # At the apex nothing moves but the turning body.
    assert at(pairs[NORM][0], middle) == pytest.approx(2.5 / FLY, rel=1e-3)


def test_weight_is_carried_in_stance(pairs, robot):
    assert at(pairs[FORCE][0], 0.1) == pytest.approx(robot.mass * GRAVITY, rel=1e-3)
    assert at(pairs[FORCE][1], 2.2) == pytest.approx(robot.mass * GRAVITY, rel=1e-2)


def test_the_simulated_yaw_rate_is_the_yaws_slope(pairs):
    yaw, rate = pairs[YAW][1], pairs[YAW_RATE][1]
    slope = np.gradient(np.radians(yaw.values), yaw.time)
    assert rate.values == pytest.approx(slope, abs=0.05)


def test_the_yaw_rate_is_about_the_worlds_vertical(planned, rollout):
    """A tilted base turns about another axis than its own."""
    tilt = Rotation.from_euler("x", 0.5)
    base = Rotation.from_quat(rollout.base_quat, scalar_first=True)
    qvel = rollout.qvel.copy()
    qvel[:, 3:6] = tilt.inv().apply(qvel[:, 3:6])
    tilted = replace(rollout, base_quat=(base * tilt).as_quat(scalar_first=True), qvel=qvel)
    upright, leaning = (curves(planned, r)[YAW_RATE][1].values for r in (rollout, tilted))
    assert leaning == pytest.approx(upright)


def test_every_impulse_is_in_the_force(pairs, rollout):
    force = pairs[FORCE][1]
    ends = np.append(force.time, rollout.time[-1] + rollout.time[1])
    impulse = np.sum(force.values * np.diff(ends))
    assert impulse == pytest.approx(rollout.contact_force[..., 2].sum() * rollout.time[1])


def test_a_detection_of_two_ticks_is_seen(pairs, rollout):
    threshold, signal = pairs[DETECTION]
    assert (rollout.detection_signal > THRESHOLD).sum() <= 3
    assert signal.values.max() > THRESHOLD
    assert threshold.values.tolist() == [THRESHOLD, THRESHOLD]


def test_a_hard_impact_leaves_the_threshold_in_sight(planned, rollout):
    hard = replace(rollout, detection_signal=rollout.detection_signal * 1e4)
    assert curves(planned, hard)[DETECTION][1].values.max() == pytest.approx(3 * THRESHOLD)
