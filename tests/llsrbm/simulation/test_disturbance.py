"""Draws: repeatable, within what is promised, and scaled about the nominal world."""

from dataclasses import asdict, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from llsrbm.motion.rollout import Disturbance
from llsrbm.request.scenario import MOST_NOISE, Scenario
from llsrbm.robots import load_robot
from llsrbm.simulation.disturbance import draw_disturbance

GO2 = load_robot("go2")
SEEDS = st.integers(0, 2**32)


@given(SEEDS)
def test_a_seed_draws_within_the_benchmarks_spread(seed):
    drawn = draw_disturbance(GO2, Scenario(seed=seed))
    assert 0.92 <= drawn.trunk_mass_factor <= 1.08
    assert 0.5 <= drawn.friction <= 1.0
    assert 0.003 <= drawn.contact_time <= 0.020
    assert drawn.torque_delay_ticks in (0, 1)
    assert 0.8 <= drawn.armature_factor <= 1.2
    assert 0.5 <= drawn.joint_friction_factor <= 2
    assert drawn.base_velocity_noise == 0.01
    assert drawn.joint_velocity_noise == 0.02
    assert drawn == draw_disturbance(GO2, Scenario(seed=seed, board=0.02, detector="paper"))


def test_draws_fill_their_ranges():
    drawn = [draw_disturbance(GO2, Scenario(seed=seed)) for seed in range(400)]
    for name, low, high in (
        ("trunk_mass_factor", 0.92, 1.08),
        ("friction", 0.5, 1.0),
        ("contact_time", 0.003, 0.020),
        ("armature_factor", 0.8, 1.2),
    ):
        values = [getattr(one, name) for one in drawn]
        slack = 0.02 * (high - low)
        assert min(values) < low + slack
        assert max(values) > high - slack
        assert sum(values) / len(values) == pytest.approx((low + high) / 2, rel=0.1)
    # Half as much friction is as far as twice.
    losses = np.log2([one.joint_friction_factor for one in drawn])
    assert (losses.min(), losses.max()) == pytest.approx((-1, 1), abs=0.04)
    assert losses.mean() == pytest.approx(0, abs=0.1)
    assert sum(one.torque_delay_ticks for one in drawn) == pytest.approx(200, abs=40)


@given(SEEDS, st.floats(0, 1))
def test_noise_scales_about_the_nominal_world(seed, noise):
    nominal, full = Disturbance(), draw_disturbance(GO2, Scenario(seed=seed))
    some = draw_disturbance(GO2, Scenario(seed=seed, noise=noise))
    for name in asdict(nominal):
        if name == "joint_friction_factor":  # by its logarithm
            assert getattr(some, name) == pytest.approx(getattr(full, name) ** noise)
        elif name not in ("torque_delay_ticks", "random_push"):
            at_rest, whole = getattr(nominal, name), getattr(full, name)
            assert getattr(some, name) == pytest.approx(at_rest + noise * (whole - at_rest))
    assert some.torque_delay_ticks <= full.torque_delay_ticks


@given(SEEDS)
def test_nothing_is_disturbed_without_a_seed_or_without_noise(seed):
    assert draw_disturbance(GO2, Scenario(seed=None)) == Disturbance()
    assert draw_disturbance(GO2, Scenario(seed=seed, noise=0.0)) == Disturbance()


@given(SEEDS, st.floats(0, MOST_NOISE))
def test_however_large_the_noise_it_stays_physical(seed, noise):
    drawn = draw_disturbance(GO2, Scenario(seed=seed, noise=noise))
    assert drawn.trunk_mass_factor > 0
    assert drawn.armature_factor >= 0
    assert drawn.joint_friction_factor > 0
    assert drawn.friction >= 0.2
    assert drawn.contact_time >= 0.002


@given(SEEDS | st.none(), st.floats(-0.5, 0.5), st.floats(0, MOST_NOISE))
def test_a_stated_trunk_mass_replaces_the_drawn_one_alone(seed, share, noise):
    drawn = draw_disturbance(GO2, Scenario(seed=seed, noise=noise))
    stated = draw_disturbance(GO2, Scenario(seed=seed, noise=noise, trunk_mass=share))
    assert stated == replace(drawn, trunk_mass_factor=1 + share)
