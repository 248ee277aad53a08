from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from app.motion.baked import bake_plan
from llsrbm.request.tuning import Tuning
from llsrbm.robots import load_robot
from tests.app.picture.overlays.drawn import DrawnOverlay
from tests.app.picture.pictures import picture, planned


def with_friction(mu, robot):
    """A picture of a plan that was asked for with another coefficient."""
    plan = replace(planned(robot).plan, tuning=Tuning({}, {"friction": mu}))
    return replace(picture(robot, {"friction"}), planned=bake_plan(plan, load_robot(robot)))


@pytest.mark.parametrize("robot", ["anymal", "slider"])
@pytest.mark.parametrize("mu", [None, 0.3, 1.2])
def test_its_edges_lie_in_the_cone_of_friction(robot, mu):
    shown = picture(robot, {"friction"}) if mu is None else with_friction(mu, robot)
    expected = load_robot(robot).file.limits.friction if mu is None else mu
    drawn = DrawnOverlay(shown, "/pyramids")
    frames = shown.planned.frames
    assert len(drawn.nodes) == frames.contact.shape[1]
    for foot, node in enumerate(drawn.nodes):
        from_tip = drawn.vertices(node, 3) - frames.pressed_at[3, foot]
        edges = np.unique(np.round(from_tip[from_tip[:, 2] > 1e-6], 9), axis=0)
        assert len(edges) == 4
        angles = np.arctan2(np.linalg.norm(edges[:, :2], axis=1), edges[:, 2])
        assert angles == pytest.approx([math.atan(expected)] * 4, rel=1e-5)
        # The planner's rows: |f_x|, |f_y| <= mu / sqrt(2) f_z, along the world's axes.
        steepness = np.abs(edges[:, :2]) / edges[:, 2:]
        assert steepness == pytest.approx(np.full((4, 2), expected / math.sqrt(2)), rel=1e-5)


@pytest.mark.parametrize("simulation", [False, True])
def test_pyramids_stand_where_feet_do(simulation):
    shown = picture("anymal", {"friction"}, simulation=simulation)
    drawn = DrawnOverlay(shown, "/pyramids")
    for foot, node in enumerate(drawn.nodes):
        there = drawn.size(node)[:, 2] > 0
        assert (there == shown.solid.contact[:, foot]).all()
        assert 0 < there.sum() < len(there)
