"""Links that are near each other, against coal's distances of postures beside."""

import coal
import numpy as np
import pinocchio as pin
import pytest

from llsrbm.robots import load_robot
from llsrbm.robots.link_shapes import LinkShapes
from llsrbm.robots.near_links import NearLinks, away_from


def _of_shapes(shapes, postures):
    """(T, K) m, of all pairs of shapes."""
    model, geometry = shapes.robot.model, shapes.geometry
    data, placed = model.createData(), geometry.createData()
    found = []
    for q in postures:
        pin.computeDistances(model, data, geometry, placed, q)
        found.append([result.min_distance for result in placed.distanceResults])
    return np.array(found)


def _nearest(robot, links, q, within):
    data = robot.model.createData()
    pin.computeJointJacobians(robot.model, data, q)
    return links.at(data, q, links.within(within))


@pytest.mark.parametrize("name", ["go2", "g1"])
def test_how_joints_move_links_apart_is_what_differences_say(name):
    robot = load_robot(name)
    shapes = LinkShapes.of(robot)
    links = NearLinks.of(robot)
    rng = np.random.default_rng(5)
    postures = np.tile(robot.posture, (6, 1))
    postures[:, 7:] += rng.normal(scale=0.1, size=(6, robot.model.nq - 7))
    step = rng.normal(size=postures.shape[1] - 7)
    moved = [postures + 1e-5 * np.r_[np.zeros(7), sign * step] for sign in (1, -1)]
    there, ahead, back = (_of_shapes(shapes, q) for q in (postures, *moved))
    for t in range(len(postures)):
        found = _nearest(robot, links, postures[t], 0.2)
        assert len(found) >= 2
        for near in found[:2]:
            k = np.abs(there[t] - near.distance).argmin()
            assert there[t, k] == pytest.approx(near.distance, abs=1e-6)
            rise = (ahead[t, k] - back[t, k]) / 2e-5
            assert rise == pytest.approx(near.slope @ step, abs=5e-3)
    assert not _nearest(robot, links, postures[0], 1e-6)


@pytest.mark.parametrize("name", ["go2"])
def test_how_a_robot_moves_away_from_a_box_is_what_differences_say(name):
    robot = load_robot(name)
    shapes, model, data = LinkShapes.of(robot), robot.model, robot.model.createData()
    rng = np.random.default_rng(3)
    box, there = coal.Box(0.4, 0.3, 0.2), pin.SE3(np.eye(3), np.array([0.5, 0.4, 0.1]))
    for _ in range(5):
        q = pin.integrate(model, robot.posture, rng.normal(scale=0.1, size=model.nv))
        pin.computeJointJacobians(model, data, q)
        bounds = shapes.least_from(q[None], box, there)[0]
        distance, slope = away_from(shapes, data, box, there, bounds, 1.0)
        step = rng.normal(size=model.nv)
        beside = np.array([pin.integrate(model, q, sign * 1e-5 * step) for sign in (-1, 0, 1)])
        back, here, ahead = shapes.clearance(beside, box, there)
        assert distance == pytest.approx(here, abs=1e-6)
        assert (ahead - back) / 2e-5 == pytest.approx(slope @ step, abs=5e-3)


@pytest.mark.parametrize("name", ["go2"])
def test_pairs_left_unmeasured_are_not_near(name):
    robot = load_robot(name)
    links, rng = NearLinks.of(robot), np.random.default_rng(4)
    q = robot.posture.copy()
    for _ in range(60):
        q[7:] += rng.normal(scale=0.03, size=len(q) - 7)
        kept = [near.distance for near in _nearest(robot, links, q, 0.05)]
        anew = [near.distance for near in _nearest(robot, NearLinks.of(robot), q, 0.05)]
        np.testing.assert_allclose(kept, anew, atol=1e-5)


def test_links_that_would_meet_soonest_are_of_different_limbs():
    """Go2's thighs are always near its base, and hardly move there."""
    robot = load_robot("go2")
    shapes = LinkShapes.of(robot)
    links = NearLinks.of(robot)
    closing = robot.posture.copy()
    for leg, sign in ((0, -1), (1, 1)):
        closing[robot.legs[leg].q_index[0]] += sign * 0.3
    first = _nearest(robot, links, closing, 0.15)[0]
    front = [robot.legs[leg].q_index[0] - 7 for leg in (0, 1)]
    assert abs(first.slope[front[0]]) > 0.1
    assert first.slope[front[0]] == pytest.approx(-first.slope[front[1]], abs=0.02)
    assert first.distance > shapes.least(closing[None])[0]
