from __future__ import annotations

import numpy as np
import pytest

from app.scene.scene import Scene
from tests.app.scene.pictures import picture, planned
from tests.app.scene.recorded import RecordedClient


@pytest.mark.parametrize("robot", ["anymal", "slider"])
def test_marks_lie_where_the_feet_land(robot):
    client = RecordedClient()
    Scene(client).draw(picture(robot, {"landing"}, height=0.1))
    plan = planned(robot, height=0.1).plan
    contacts = plan.contact_point[-1].reshape(plan.foot_position.shape[1], -1, 3)
    for foot, points in enumerate(contacts):
        mark = client.scene.nodes[f"/target/foot{foot}"]
        middle = (points.min(axis=0) + points.max(axis=0)) / 2
        assert mark.position[:2] == pytest.approx(middle[:2], abs=5e-3)
        assert 0.1 < mark.position[2] < 0.11


def test_a_step_is_drawn_until_a_simulation_has_its_own_blocks():
    client = RecordedClient()
    scene = Scene(client)
    scene.draw(picture("anymal", {"landing"}, height=0.2))
    step = client.scene.nodes["/target/step"]
    assert step.visible
    assert step.dimensions[2] == pytest.approx(0.2)
    assert step.position[2] == pytest.approx(0.1)
    scene.draw(picture("anymal", {"landing"}))
    assert not step.visible


def test_trails_end_where_the_motion_ends():
    client = RecordedClient()
    Scene(client).draw(picture("anymal", {"trails"}))
    com = client.scene.nodes["/path/com"].points
    frames = planned("anymal").frames
    assert com[0, 0] == pytest.approx(frames.com[0], abs=1e-6)
    assert com[-1, 1] == pytest.approx(frames.com[-1], abs=1e-6)
    assert (com[1:, 0] == com[:-1, 1]).all()
    assert np.ptp(client.scene.nodes["/path/feet"].points[..., 2]) > 0
