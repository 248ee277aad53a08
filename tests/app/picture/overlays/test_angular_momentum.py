from __future__ import annotations

import numpy as np
import pytest

from app.picture.overlays.angular_momentum import METRES_PER_UNIT, AngularMomentum
from tests.app.picture.overlays.drawn import DrawnOverlay
from tests.app.picture.pictures import picture, planned


@pytest.mark.parametrize("robot", ["anymal", "slider"])
@pytest.mark.parametrize("twist", [0.7, -0.7])
def test_it_points_along_the_plans_from_the_com(robot, twist):
    shown = picture(robot, {"spin"}, twist=twist)
    drawn = DrawnOverlay(shown, "/momentum")
    plan = planned(robot, twist).plan
    frames = shown.solid
    frame = int(np.abs(frames.time - 0.65).argmin())
    knot = int(np.abs(plan.time - frames.time[frame]).argmin())
    (node,) = drawn.nodes
    vertices = drawn.vertices(node, frame)
    tip = vertices[np.linalg.norm(vertices - frames.com[frame], axis=1).argmax()]
    arrow, expected = tip - frames.com[frame], plan.angular_momentum[knot]
    assert np.linalg.norm(np.cross(arrow, expected)) < 1e-3 * np.linalg.norm(expected)
    assert arrow @ expected > 0
    length = np.linalg.norm(expected) * METRES_PER_UNIT
    assert np.linalg.norm(arrow) == pytest.approx(length, rel=1e-3)
    assert f"{METRES_PER_UNIT:g} m" in AngularMomentum.hint


def test_what_does_not_turn_has_no_arrow():
    drawn = DrawnOverlay(picture("anymal", {"spin"}), "/momentum")
    assert drawn.size(drawn.nodes[0])[0].tolist() == [0, 0, 0]
