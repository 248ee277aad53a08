from dataclasses import replace

import numpy as np
import pytest

from app.motion.baked import bake_plan
from app.picture.scene import Scene
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.app.picture.pictures import picture, planned
from tests.app.picture.recorded import RecordedClient
from tests.app.synthetic_plan import synthetic_plan


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


def test_every_landing_has_its_marks():
    client = RecordedClient()
    scene = Scene(client)
    shown = picture("anymal", {"landing"})
    plan = synthetic_plan(Jump(type="hops", hops=2, forward=0.3, height=0.1))
    scene.draw(replace(shown, planned=bake_plan(plan, load_robot("anymal"))))
    feet = load_robot("anymal").feet
    for landing in (1, 2):
        for foot, start in enumerate(feet):
            mark = client.scene.nodes[f"/target/foot{4 * (landing - 1) + foot}"]
            assert mark.visible
            assert mark.position[0] == pytest.approx(start[0] + 0.3 * landing)
            assert 0 < mark.position[2] - start[2] - 0.1 * landing < 0.01
    scene.draw(shown)
    visible = [client.scene.nodes[f"/target/foot{i}"].visible for i in range(8)]
    assert visible == [True] * 4 + [False] * 4


def test_feet_that_stand_have_no_trail():
    client = RecordedClient()
    plan = synthetic_plan(Jump(type="rear-last", forward=0.3))
    shown = picture("anymal", {"trails"})
    Scene(client).draw(replace(shown, planned=bake_plan(plan, load_robot("anymal"))))
    drawn = client.scene.nodes["/path/feet"].points.reshape(-1, 3)
    # A front foot's trail begins where it is lifted, before the flight: it still lies there.
    front, hind = plan.foot_position[0, 0], plan.foot_position[0, 2]
    assert (np.linalg.norm(drawn - front, axis=1) < 1e-6).sum() > 1
    assert (np.linalg.norm(drawn - hind, axis=1) < 1e-6).sum() <= 1


def test_a_step_is_drawn_until_a_simulation_has_its_own_blocks():
    client = RecordedClient()
    scene = Scene(client)
    scene.draw(picture("anymal", {"landing"}, height=0.2))
    step = client.scene.nodes["/target/step0"]
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
