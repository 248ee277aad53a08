"""Robots as nodes: shapes stand in for meshes that are not prepared yet."""

import itertools

import pytest

from app.picture.robot_nodes import RobotNodes, RobotShelf, meshes
from llsrbm.cache import ENVIRONMENT_VARIABLE
from llsrbm.look.visuals import link_visuals, needs_preparation
from llsrbm.robots import load_robot
from tests.app.picture.recorded import RecordedScene


@pytest.fixture
def unprepared(monkeypatch, tmp_path):
    """A machine's first start; `.undo()` prepares the meshes: back to the cache with them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(ENVIRONMENT_VARIABLE, str(tmp_path))
        yield patch


@pytest.mark.parametrize("name", ["anymal", "go2"])
def test_shapes_stand_in_until_the_meshes_are_prepared(name, unprepared):
    robot, scene = load_robot(name), RecordedScene()
    assert needs_preparation(robot)
    nodes = RobotNodes(scene, robot, "/links")
    shapes = meshes(robot, stand_in=True)
    assert {f"/links/{link}" for link, _, _ in shapes} | {"/links"} == set(scene.nodes)
    nodes.complete()  # too early
    nodes.refine()
    for link, _, glb in shapes:
        assert scene.nodes[f"/links/{link}"].glb_data == glb
    unprepared.undo()
    link_visuals(robot, coarse=True)
    nodes.complete()
    fine = meshes(robot, fine=True)
    assert {f"/links/{link}" for link, _, _ in fine} | {"/links"} == set(scene.nodes)
    for link, _, glb in fine:
        assert scene.nodes[f"/links/{link}"].glb_data == glb
    assert len(nodes.still().tracks) == len(fine)
    changes = len(scene.changes)
    nodes.complete()
    assert len(scene.changes) == changes


def test_a_robot_that_stands_has_all_triangles_which_are_sent_once():
    robot, scene = load_robot("anymal"), RecordedScene()
    nodes = RobotNodes(scene, robot, "/links")
    assert not nodes.stand(still=False)
    assert nodes.stand(still=True)
    names = [track.nodes for track in nodes.still().tracks]
    for link, _, glb in meshes(robot, fine=True):
        assert scene.nodes[f"/links-still/{link}"].glb_data == glb
        assert (f"/links/{link}", f"/links-still/{link}") in names
    assert {name.split("/")[1] for name in scene.seen()} == {"links-still"}
    made = len(scene.made)
    assert not nodes.stand(still=False)
    assert {name.split("/")[1] for name in scene.seen()} == {"links"}
    assert not nodes.stand(still=True)
    assert len(scene.made) == made
    nodes.remove()
    assert scene.nodes == {}


def test_a_shelf_completes_the_robot_that_is_taken(unprepared):
    robot, scene = load_robot("anymal"), RecordedScene()
    shelf = RobotShelf(scene, (f"/robot{number}" for number in itertools.count()))
    taken = [shelf.take(robot), shelf.take(robot, ghost=(1, 2, 3))]
    unprepared.undo()
    link_visuals(robot, coarse=True)
    assert [shelf.take(robot), shelf.take(robot, ghost=(1, 2, 3))] == taken
    for name, ghost in (("/robot0", None), ("/robot1", (1, 2, 3))):
        for link, _, glb in meshes(robot, ghost=ghost):
            assert scene.nodes[f"{name}/{link}"].glb_data == glb


@pytest.mark.usefixtures("unprepared")
def test_a_robot_of_boxes_is_drawn_as_it_is_at_once():
    robot, scene = load_robot("slider"), RecordedScene()
    RobotNodes(scene, robot, "/links")
    assert {f"/links/{link}" for link, _, _ in meshes(robot)} | {"/links"} == set(scene.nodes)
