from __future__ import annotations

import numpy as np
import pytest

from tests.app.picture.overlays.drawn import DrawnOverlay
from tests.app.picture.pictures import picture


@pytest.mark.parametrize("robot", ["anymal", "slider"])
def test_the_ground_has_no_moment_there(robot):
    """Over all contacts, sum (p_i - c) x f_i has no horizontal part: the definition."""
    shown = picture(robot, {"pressure"})
    drawn, plan = DrawnOverlay(shown, "/zmp"), shown.planned.plan
    (node,) = drawn.nodes
    frames, knot = shown.solid, 4
    frame = int(np.abs(frames.time - plan.time[knot]).argmin())
    vertices = drawn.vertices(node, frame)
    centre = (vertices.max(axis=0) + vertices.min(axis=0)) / 2
    arm = plan.contact_point[knot] - centre * [1, 1, 0]
    moment = np.cross(arm, plan.contact_force[knot] * [0, 0, 1]).sum(axis=0)
    assert moment == pytest.approx(np.zeros(3), abs=2e-3 * frames.weight)
    # Pushed harder on one side: it is not just the middle of the feet.
    middle = plan.contact_point[knot].mean(axis=0)
    assert np.linalg.norm((centre - middle)[:2]) > 0.01


@pytest.mark.parametrize("simulation", [False, True])
def test_there_is_none_in_flight(simulation):
    shown = picture("anymal", {"pressure"}, simulation=simulation)
    drawn = DrawnOverlay(shown, "/zmp")
    there = drawn.size(drawn.nodes[0])[:, 0] > 0
    # A simulation's forces are means over a frame, which may begin in flight.
    assert there[~shown.solid.contact.any(axis=1)].sum() <= simulation
    assert there[shown.solid.contact.all(axis=1)].mean() > 0.9
