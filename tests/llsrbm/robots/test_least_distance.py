"""The least distance of a motion, against all distances."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from llsrbm.robots.least_distance import least_distance, way_of


@given(st.integers(0, 10_000))
def test_of_balls_that_wander_it_is_the_least_of_all(seed):
    rng = np.random.default_rng(seed)
    count, pairs = int(rng.integers(1, 200)), int(rng.integers(1, 6))
    at = np.cumsum(rng.normal(scale=0.02, size=(count, pairs, 3)), axis=0) + rng.normal(
        size=(pairs, 3)
    )
    distance = np.linalg.norm(at, axis=-1) - 0.2
    still = np.tile(np.eye(3), (count, 1, 1))
    measured = []

    def measure(t, k):
        measured.append((t, k))
        return distance[t, k]

    found, t, k = least_distance(
        distance - rng.uniform(0, 0.5, size=pairs),
        measure,
        lambda k: way_of(still, at[:, k], 0.0),
    )
    assert found == distance.min() == distance[t, k]


def test_most_instants_are_passed_by():
    at = np.linspace(-1.0, 1.0, 2001)[:, None, None] * [[1.0, 0.0, 0.0]] + [0.0, 0.3, 0.0]
    distance = np.linalg.norm(at, axis=-1)
    still, measured = np.tile(np.eye(3), (2001, 1, 1)), []

    def measure(t, k):
        measured.append(t)
        return distance[t, k]

    found, *_ = least_distance(distance - 1.0, measure, lambda k: way_of(still, at[:, k], 0.0))
    assert found == pytest.approx(0.3)
    assert len(measured) < 200


def test_points_of_a_ball_move_no_farther_than_its_way():
    rng = np.random.default_rng(4)
    turn = Rotation.from_rotvec(np.cumsum(rng.normal(scale=0.05, size=(100, 3)), axis=0))
    centre = np.cumsum(rng.normal(scale=0.01, size=(100, 3)), axis=0)
    way = way_of(turn.as_matrix(), centre, 0.3)
    on_it = rng.normal(size=(20, 3))
    on_it *= 0.3 / np.linalg.norm(on_it, axis=1)[:, None]
    points = np.einsum("tij,pj->tpi", turn.as_matrix(), on_it) + centre[:, None]
    since = np.linalg.norm(points - points[0], axis=-1).max(axis=1)
    assert (since <= way + 1e-12).all()
    assert way[0] == 0.0


def test_without_pairs_nothing_is_measured():
    assert least_distance(np.zeros((10, 0)), lambda t, k: 0.0, lambda k: np.zeros(10))[0] == np.inf
