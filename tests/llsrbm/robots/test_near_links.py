"""Links that are near each other, against coal's distances of postures beside."""

import numpy as np
import pinocchio as pin
import pytest

from llsrbm.robots import load_robot
from llsrbm.robots.link_shapes import LinkShapes
from llsrbm.robots.near_links import NearLinks


def _of_shapes(shapes, postures):
    """(T, K) m, of all pairs of shapes."""
    model, geometry = shapes.robot.model, shapes.geometry
    data, placed = model.createData(), geometry.createData()
    found = []
    for q in postures:
        pin.computeDistances(model, data, geometry, placed, q)
        found.append([result.min_distance for result in placed.distanceResults])
    return np.array(found)


@pytest.mark.parametrize("name", ["go2", "slider", "g1"])
def test_how_joints_move_links_apart_is_what_differences_say(name):
    robot = load_robot(name)
    shapes = LinkShapes.of(robot)
    links = NearLinks.of(robot)
    rng = np.random.default_rng(5)
    postures = np.tile(robot.posture, (6, 1))
    postures[:, 7:] += rng.normal(scale=0.1, size=(6, robot.model.nq - 7))
    least, slopes = links.soonest(postures, 2, 0.2)
    assert np.isfinite(least).all()
    step = rng.normal(size=postures.shape[1] - 7)
    moved = [postures + 1e-5 * np.r_[np.zeros(7), sign * step] for sign in (1, -1)]
    there, ahead, back = (_of_shapes(shapes, q) for q in (postures, *moved))
    for t in range(len(postures)):
        for distance, slope in zip(least[t], slopes[t], strict=True):
            k = np.abs(there[t] - distance).argmin()
            assert there[t, k] == pytest.approx(distance, abs=1e-6)
            rise = (ahead[t, k] - back[t, k]) / 2e-5
            assert rise == pytest.approx(slope @ step, abs=5e-3)
    assert np.isinf(links.soonest(postures[:1], 2, 1e-6)[0]).all()


def test_links_that_would_meet_soonest_are_of_different_limbs():
    """Go2's thighs are always near its base, and hardly move there."""
    robot = load_robot("go2")
    shapes = LinkShapes.of(robot)
    links = NearLinks.of(robot)
    closing = robot.posture.copy()
    for leg, sign in ((0, -1), (1, 1)):
        closing[robot.legs[leg].q_index[0]] += sign * 0.3
    least, slopes = links.soonest(closing[None], 4, 0.15)
    front = [robot.legs[leg].q_index[0] - 7 for leg in (0, 1)]
    assert abs(slopes[0, 0, front[0]]) > 0.1
    assert slopes[0, 0, front[0]] == pytest.approx(-slopes[0, 0, front[1]], abs=0.02)
    assert least[0, 0] > shapes.nearest(closing[None])[0][0]
