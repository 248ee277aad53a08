"""LL-SRBM+ against Pinocchio: the whole robot in random postures, moving at random.

Bounds are about twice what the fit reaches over these motions, which are wilder than a plan's.
"""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings

from llsrbm.models.llsrbm import LLSRBM, SRBM
from llsrbm.models.llsrbm_plus import LLSRBMPlus
from tests.llsrbm.models.postures import (
    ROBOT,
    SLIDER,
    evaluate,
    evaluate_momentum,
    feet_in_reach,
    feet_of,
    feet_rate_of,
    random_motions,
    rates,
)

MODEL = LLSRBMPlus(ROBOT)
SLIDING = LLSRBMPlus(SLIDER)


@pytest.fixture(scope="module")
def motions():
    return random_motions(200)


@pytest.fixture(scope="module")
def slides():
    return random_motions(200, robot=SLIDER)


def seen_by(model, motions):
    """Feet, their rates and the base's angular velocity as the model takes them."""
    feet = feet_of(model, np.array([m.beta for m in motions]))
    rate = feet_rate_of(model, np.array([m.beta_rate for m in motions]))
    return feet, rate, np.array([m.w for m in motions])


def momentum_error(model, motions):
    """RMS error of each component, share of its peak."""
    true = np.array([m.momentum for m in motions])
    error = evaluate_momentum(model, *seen_by(model, motions)) - true
    return np.sqrt(np.mean(error**2, axis=0)) / np.abs(true).max(axis=0)


def test_inertia(motions):
    true = np.array([m.inertia for m in motions])
    inertia = evaluate(MODEL, seen_by(MODEL, motions)[0])[1]
    relative = np.diagonal(inertia - true, axis1=1, axis2=2) / np.diagonal(true, axis1=1, axis2=2)
    rms = np.sqrt(np.mean(relative**2, axis=0))
    assert (rms < [0.03, 0.01, 0.01]).all(), rms
    whole = np.linalg.norm(inertia - true, axis=(1, 2)) / np.linalg.norm(true, axis=(1, 2))
    assert whole.max() < 0.035


def test_momentum(motions):
    assert (momentum_error(MODEL, motions) < [0.05, 0.03, 0.02]).all()


def test_sliding_legs_with_soles(slides):
    """Bounds about twice what is reached: Ly decides whether SLIDER's pelvis stays upright."""
    true = np.array([m.inertia for m in slides])
    _, inertia, leg_com = evaluate(SLIDING, seen_by(SLIDING, slides)[0])
    relative = np.diagonal(inertia - true, axis1=1, axis2=2) / np.diagonal(true, axis1=1, axis2=2)
    assert (np.sqrt(np.mean(relative**2, axis=0)) < [0.01, 0.01, 0.01]).all()
    assert (momentum_error(SLIDING, slides) < [0.012, 0.012, 0.012]).all()
    for other in (SRBM(SLIDER), LLSRBM(SLIDER)):
        assert (momentum_error(SLIDING, slides) < 0.1 * momentum_error(other, slides)).all()
    assert np.abs(leg_com - [m.leg_com for m in slides]).max() < 0.01


def test_a_soles_own_turn_counts():
    """About the vertical, with the inertia that the URDF gives the foot about its own CoM."""
    x = np.tile([0.0, 0.0, -0.66, 0.3], (1, 2, 1))
    turning = np.zeros_like(x)
    turning[..., 3] = 2.0, -3.0
    h = evaluate_momentum(SLIDING, x, turning, np.zeros((1, 3)))[0]
    # Outwards is to the left for the first leg, to the right for the second.
    assert h == pytest.approx([0.0, 0.0, 0.017 * (2.0 + 3.0)], abs=2e-3)


@settings(max_examples=15, deadline=None)
@given(x=feet_in_reach(), xdot=rates())
def test_the_com_moves_as_its_map_says(x, xdot):
    step = 1e-6
    for foot, speed in zip(x, xdot):
        ahead, behind = (
            np.array(MODEL.leg_com(0, ca.DM(foot + sign * step * speed))) for sign in (1, -1)
        )
        rate = np.array(MODEL.leg_com_rate(ca.DM(foot), ca.DM(speed)))
        np.testing.assert_allclose(rate, (ahead - behind) / (2 * step), atol=1e-8)
