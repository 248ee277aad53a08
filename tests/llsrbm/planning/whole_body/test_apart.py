"""Distances as straight functions, against distances of a motion beside."""

from dataclasses import replace

import coal
import numpy as np
import pinocchio as pin
import pytest

import llsrbm
from llsrbm.motion.block import Block
from llsrbm.planning.whole_body import apart
from llsrbm.planning.whole_body import start as start_module
from llsrbm.planning.whole_body.apart import BETWEEN, FAR, Apart
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.planning.whole_body.refine import refined
from llsrbm.planning.whole_body.start import CROUCHES, SINKS, start_of, trunk_room
from llsrbm.robots import load_robot
from llsrbm.robots.link_shapes import LinkShapes
from llsrbm.robots.near_links import NearLinks, away_from


@pytest.fixture(scope="module")
def plan():
    return llsrbm.plan(llsrbm.Jump(robot="go2", height=0.2, forward=0.25), draft=True)


@pytest.fixture(scope="module")
def start(plan):
    return start_of(plan, load_robot("go2"), Grid.of(plan))


def test_they_tell_how_near_things_are_beside_the_motion(start):
    robot, rng = load_robot("go2"), np.random.default_rng(0)
    planned = start.state["quat"]
    about = np.repeat(planned, 2, axis=0)[: len(start.time)]
    # All at the attitudes of the knots, the joints as they are there and in between.
    joints = np.repeat(start.state["joint_position"], 2, axis=0)[: len(start.time)]
    place = np.repeat(start.state["position"], 2, axis=0)[: len(start.time)]
    q = np.hstack([place, np.roll(about, -1, axis=1), joints])
    step = 1e-4 * rng.normal(size=robot.model.nv)
    moved = np.array([pin.integrate(robot.model, each, step) for each in q])
    here, there = (
        Apart.near(each, start.time, planned, robot, start.solids, np.zeros(len(q)))
        for each in (q, moved)
    )
    shift = moved[:, :3] - q[:, :3]
    state = np.hstack([place + shift, np.tile(step[3:6], (len(q), 1)), moved[:, 7:]])
    expected = (here.at_zero + np.einsum("tni,ti->tn", here.slope, state)).min(axis=1) + BETWEEN
    known = np.isfinite(there.least) & (expected < FAR)
    assert known.sum() > 20
    np.testing.assert_allclose(expected[known], there.least[known], atol=1e-5)


def test_the_box_that_is_jumped_onto_is_among_them(monkeypatch, plan):
    monkeypatch.setattr(apart, "NEAR", 0.15)  # its trunk passes it by some 10 cm
    start = start_of(plan, load_robot("go2"), Grid.of(plan))
    assert "box" in [solid.name for solid in start.solids]
    of_base = np.abs(start.apart.slope[:, :, :3]).max(axis=(1, 2))
    assert (of_base > 0.5).any()


def lowest_once_landed(plan):
    """m, of the base's origin above the feet."""
    landed = plan.time >= plan.touchdown
    return plan.base_position[landed, 2].min() - plan.foot_position[-1, :, 2].min()


def test_once_it_has_landed_the_trunk_keeps_from_the_ground(monkeypatch):
    draft = llsrbm.plan(llsrbm.Jump(robot="go2", twist=2.32), draft=True)
    keeps = refined(draft)
    assert keeps.refined
    monkeypatch.setattr(start_module, "SINKS", 0.0)
    assert lowest_once_landed(keeps) > lowest_once_landed(refined(draft)) + 0.03


def test_the_trunk_keeps_away_where_legs_stand_and_more_after_every_flight():
    all_legs, none = (0, 1, 2, 3), ()
    phases = tuple((legs, 2) for legs in (all_legs, none, all_legs, none, all_legs))
    room = trunk_room(Grid(phases))
    np.testing.assert_array_equal(np.flatnonzero(room == SINKS), [*range(8, 12), *range(16, 21)])
    np.testing.assert_array_equal(np.flatnonzero(room == CROUCHES), range(4))
    np.testing.assert_array_equal(np.flatnonzero(room == 0), [*range(4, 8), *range(12, 16)])


def test_a_trunk_that_sinks_is_among_them_however_many_links_are_near(monkeypatch):
    monkeypatch.setattr(apart, "NEAR", 0.2)  # more pairs than there are rows
    robot = load_robot("go2")
    ground = Block("ground", np.array([0.0, 0.0, -0.5]), np.array([9.0, 9.0, 1.0]), 0.0)
    q, upright = np.tile(robot.posture, (3, 1)), np.tile([1.0, 0.0, 0.0, 0.0], (2, 1))
    room = 0.01
    kept = _under_the_trunk(robot) - room
    found = Apart.near(q, np.arange(3.0), upright, robot, (ground,), np.full(3, kept))
    of_trunk = ~found.slope[1, :, 6:].any(axis=1) & found.slope[1, :, :3].any(axis=1)
    assert of_trunk.sum() == 1
    np.testing.assert_allclose(found.slope[1, of_trunk, :3], [[0.0, 0.0, 1.0]], atol=1e-6)


def _under_the_trunk(robot):
    """m from the ground to the lowest point of what does not move with a joint."""
    shapes, ground = LinkShapes.of(robot), coal.Box(9.0, 9.0, 1.0)
    below = pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.5]))
    bounds = NearLinks.of(robot).shapes.least_from(robot.posture[None], ground, below)[0]
    of_trunk = np.array([shape.joint == 1 for shape in shapes.shapes])
    data = robot.model.createData()
    pin.computeJointJacobians(robot.model, data, robot.posture)
    inside = np.where(of_trunk, bounds, np.inf)
    return float(away_from(shapes, data, ground, below, inside, 1.0)[0])


def test_a_robot_whose_links_stand_close_together_may_stand_so():
    """Rows keep links farther apart than they may be, but not farther than they stand."""
    robot = load_robot("a1")
    inward = robot.posture.copy()
    shapes = LinkShapes.of(robot)
    pair = next(k for k, pair in enumerate(shapes.pairs) if set(pair) == {"FL_foot", "FR_foot"})
    angle = 0.0
    while shapes.distances(inward)[pair] > 0.009:
        angle += 0.001
        for leg, sign in ((0, -1), (1, 1)):
            at = robot.legs[leg].q_index[0]
            inward[at] = robot.posture[at] + sign * angle
    close = replace(robot, posture=inward)
    q, upright = np.tile(inward, (3, 1)), np.tile(inward[[6, 3, 4, 5]], (2, 1))
    found = Apart.near(q, np.arange(3.0), upright, close, (), np.zeros(3))
    state = np.concatenate([inward[:3], np.zeros(3), inward[7:]])
    assert 0 < found.least[1] < BETWEEN
    assert (found.at_zero[1:] + found.slope[1:] @ state >= 0).all()
