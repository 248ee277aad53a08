"""The filter: its error's dynamics by finite differences, a textbook's update, convergence."""

from copy import deepcopy

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from llsrbm.estimation.invariant_filter import FIRST_FOOT, InvariantFilter

LEGS = 2
SIZE = FIRST_FOOT + 3 * LEGS
NO_NOISE = np.zeros(SIZE)
STILL = np.zeros((LEGS, 3))
UP = np.array([0.0, 0.0, 9.81])
BOTH = np.ones(LEGS, dtype=bool)
SMALL = 1e-6

seeds = st.integers(0, 10_000)
few = settings(max_examples=10, deadline=None)


def belief(seed):
    """Any state."""
    rng = np.random.default_rng(seed)
    made = InvariantFilter(LEGS)
    made.R_world_base = pin.exp3(rng.standard_normal(3))
    made.velocity, made.position, made.gyro_bias, made.acceleration_bias = rng.standard_normal(
        (4, 3)
    )
    made.feet = rng.standard_normal((LEGS, 3))
    return made, rng


def wrong_by(true, xi):
    """exp(xi) X, to first order where it is not a rotation."""
    turned, R = deepcopy(true), pin.exp3(xi[:3])
    turned.R_world_base = R @ true.R_world_base
    turned.velocity = R @ true.velocity + xi[3:6]
    turned.position = R @ true.position + xi[6:9]
    turned.gyro_bias = true.gyro_bias + xi[9:12]
    turned.acceleration_bias = true.acceleration_bias + xi[12:15]
    turned.feet = true.feet @ R.T + xi[15:].reshape(-1, 3)
    return turned


def error(estimated, true):
    """The xi that is between two states, likewise."""
    R = estimated.R_world_base @ true.R_world_base.T
    return np.concatenate(
        [
            pin.log3(R),
            estimated.velocity - R @ true.velocity,
            estimated.position - R @ true.position,
            estimated.gyro_bias - true.gyro_bias,
            estimated.acceleration_bias - true.acceleration_bias,
            (estimated.feet - true.feet @ R.T).ravel(),
        ]
    )


@given(seeds)
@few
def test_errors_spread_as_the_covariance_says(seed):
    """A covariance of rank one is an error's; it must go where the error goes."""
    true, rng = belief(seed)
    xi, dt = rng.standard_normal(SIZE), 1e-4
    estimated = wrong_by(true, SMALL * xi)
    estimated.covariance = np.outer(xi, xi)
    gyro, acceleration = rng.standard_normal((2, 3))
    for each in (true, estimated):
        each.propagate(dt, gyro, acceleration, STILL, NO_NOISE)
    after = error(estimated, true) / SMALL
    # The filter's transition is exact to second order in dt but for the biases' part, which is
    # exact to the first.
    np.testing.assert_allclose(estimated.covariance, np.outer(after, after), atol=1e-5)
    assert np.abs(after - xi).max() > 1e-5


@given(seeds)
@few
def test_a_gyroscopes_noise_turns_what_is_in_the_world(seed):
    true, rng = belief(seed)
    gyro, acceleration, noise = rng.standard_normal((3, 3))
    dt = 1e-4
    one, other = deepcopy(true), deepcopy(true)
    variances = np.zeros(SIZE)
    variances[:3] = 1.0
    one.propagate(dt, gyro, acceleration, STILL, NO_NOISE)
    other.propagate(dt, gyro + SMALL * noise, acceleration, STILL, variances)
    by_noise = error(other, one) / SMALL / dt
    # Its direction lies in what the covariance spans, which has rank three.
    spread = other.covariance / dt
    values, vectors = np.linalg.eigh(spread)
    assert np.sum(values > 1e-9) == 3
    inside = vectors[:, -3:]
    np.testing.assert_allclose(inside @ (inside.T @ by_noise), by_noise, atol=2e-2)


@given(seeds)
@few
def test_an_innovation_is_the_error_of_base_less_foot(seed):
    true, rng = belief(seed)
    places = (true.feet - true.position) @ true.R_world_base
    np.testing.assert_allclose(true.innovation(places), 0, atol=1e-12)
    xi = rng.standard_normal(SIZE)
    seen = wrong_by(true, SMALL * xi).innovation(places) / SMALL
    expected = xi[6:9] - xi[15:].reshape(-1, 3)
    np.testing.assert_allclose(seen, expected, atol=1e-4)


def positive(rng):
    root = rng.standard_normal((SIZE, SIZE))
    return root @ root.T + np.eye(SIZE)


@given(seeds, st.sampled_from([[True, True], [False, True], [True, False]]))
@few
def test_a_correction_is_the_textbooks(seed, stands):
    estimated, rng = belief(seed)
    estimated.covariance = C = positive(rng)
    before, stands = deepcopy(estimated), np.array(stands)
    z = SMALL * rng.standard_normal((LEGS, 3))
    estimated.correct(stands, z, 0.5)
    H = np.zeros((3 * LEGS, SIZE))
    for i in range(LEGS):
        H[3 * i : 3 * i + 3, 6:9] = np.eye(3)
        H[3 * i : 3 * i + 3, 15 + 3 * i : 18 + 3 * i] = -np.eye(3)
    H = H[stands.repeat(3)]
    S = H @ C @ H.T + 0.5 * np.eye(len(H))
    K = C @ H.T @ np.linalg.inv(S)
    np.testing.assert_allclose(estimated.covariance, (np.eye(SIZE) - K @ H) @ C, atol=1e-8)
    np.testing.assert_allclose(error(estimated, before), -K @ z[stands].ravel(), atol=1e-9)
    surprise = before.surprise(z, 0.5)[stands]
    for i, block in enumerate(np.split(H, len(H) // 3)):
        S = block @ C @ block.T + 0.5 * np.eye(3)
        assert surprise[i] == pytest.approx(z[stands][i] @ np.linalg.inv(S) @ z[stands][i])


@given(seeds)
@few
def test_a_foot_is_planted_where_it_is_and_errs_as_the_base(seed):
    estimated, rng = belief(seed)
    estimated.covariance = positive(rng)
    place = rng.standard_normal(3)
    estimated.plant(1, place, 0.1)
    np.testing.assert_allclose(estimated.innovation(np.array([place, place]))[1], 0, atol=1e-12)
    C = estimated.covariance
    difference = C[6:9, 6:9] + C[18:, 18:] - C[6:9, 18:] - C[18:, 6:9]
    np.testing.assert_allclose(difference, 0.1 * np.eye(3), atol=1e-9)
    np.testing.assert_allclose(C, C.T)
    estimated.lift(1)
    assert not estimated.covariance[18:].any()
    assert not estimated.covariance[:, 18:].any()


def test_a_standing_body_finds_its_tilt_speed_and_gyroscopes_bias():
    """Noise-free readings; yaw and the split of tilt and accelerometer's bias cannot be known."""
    true = InvariantFilter(LEGS)
    true.position = np.array([0.0, 0.0, 0.5])
    true.feet = np.array([[0.1, 0.2, 0.0], [-0.1, -0.2, 0.0]])
    places = true.feet - true.position
    xi = np.zeros(SIZE)
    xi[:3], xi[3:6], xi[9:12] = [0.05, -0.04, 0.0], [0.1, -0.2, 0.1], [0.01, -0.02, 0.0]
    estimated = wrong_by(true, xi)
    variances = np.zeros(SIZE)
    variances[:2], variances[3:6], variances[9:12] = 0.05**2, 0.2**2, 0.02**2
    estimated.covariance = np.diag(variances)
    for foot in range(LEGS):
        estimated.plant(foot, places[foot], 1e-6)
    noise = np.full(SIZE, 1e-8)
    for _ in range(2000):
        estimated.propagate(1e-3, np.zeros(3), UP, STILL, noise)
        estimated.correct(BOTH, estimated.innovation(places), 1e-6)
    left = error(estimated, true)
    assert np.abs(left[:2]).max() < 1e-3
    assert np.abs(left[3:6]).max() < 2e-3
    assert np.abs(left[9:11]).max() < 1e-3
