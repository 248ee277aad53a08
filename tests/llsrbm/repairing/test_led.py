"""A way of which a share is gone, against places that are known."""

import numpy as np
import pytest

from llsrbm.mechanics import quaternions_about_z, yaw
from llsrbm.repairing.led import Led, Way

WAY = Way(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), np.array([0.0, np.pi / 2, np.pi / 2]))


def test_steps_are_ahead_and_to_the_left():
    np.testing.assert_allclose(WAY.steps, [[1.0, 0.0], [1.0, 0.0]], atol=1e-12)


@pytest.mark.parametrize("share", [1.0, 0.5, 0.0])
def test_a_share_of_a_way_has_a_share_of_each_step_and_turn(share):
    shared = WAY.shared(share)
    np.testing.assert_allclose(shared.steps, share * WAY.steps, atol=1e-12)
    np.testing.assert_allclose(shared.headings, share * WAY.headings)
    np.testing.assert_allclose(shared.middles[0], WAY.middles[0])


def test_half_the_way_leads_where_it_does():
    np.testing.assert_allclose(
        WAY.shared(0.5).middles, [[0, 0], [0.5, 0], [0.5 + 0.5**1.5, 0.5**1.5]], atol=1e-12
    )


def test_points_keep_their_place_about_the_middles():
    led = Led(WAY, WAY.shared(0.5))
    ahead = np.array([[0.1, 0.0, 0.2], [1.0, 0.1, 0.2], [1.0, 1.1, 0.2]])  # of each, as it looks
    moved = led.points(ahead)
    np.testing.assert_allclose(moved[:, 2], 0.2)
    off = moved[:, :2] - led.to.middles
    np.testing.assert_allclose(np.arctan2(*off.T[::-1]), led.to.headings, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(off, axis=1), 0.1)


def test_what_leads_all_the_way_stays():
    way = WAY.at(np.linspace(0, 2, 7))
    points = np.random.default_rng(1).normal(size=(7, 4, 3))
    np.testing.assert_allclose(Led(way, way).points(points), points, atol=1e-12)


def test_attitudes_turn_with_the_headings():
    at = np.array([0.0, 0.5, 1.0])
    led = Led(WAY.at(at), WAY.shared(0.5).at(at))
    turned = yaw(led.attitudes(quaternions_about_z(np.array([0.0, np.pi / 4, np.pi / 2]))))
    np.testing.assert_allclose(turned, [0.0, np.pi / 8, np.pi / 4], atol=1e-12)
