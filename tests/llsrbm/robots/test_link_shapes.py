"""Shapes of links, pairs that can meet, and distances that can be worked out by hand."""

from dataclasses import replace

import coal
import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial import ConvexHull

from llsrbm.errors import RobotFileError
from llsrbm.robots import load_robot
from llsrbm.robots.feet import collision_shapes, foot_contacts
from llsrbm.robots.link_shapes import LinkShapes
from llsrbm.robots.schema import read_robot_file, robot_files
from llsrbm.robots.shapes import link_shapes
from llsrbm.robots.urdf import find_urdf

A1 = robot_files()["a1"].read_text()


def _pair(shapes, one, other):
    return next(k for k, pair in enumerate(shapes.pairs) if set(pair) == {one, other})


@pytest.mark.parametrize("name", ["anymal", "slider"])
def test_every_body_has_a_shape_and_no_pair_touches_at_rest(name):
    robot = load_robot(name)
    shapes = LinkShapes.of(robot)
    assert {shape.joint for shape in shapes.shapes} == set(range(1, robot.model.njoints))
    assert len({frozenset(pair) for pair in shapes.pairs}) == len(shapes.pairs) > 0
    assert shapes.distances(robot.posture).min() > 0
    joint = {shape.link: shape.joint for shape in shapes.shapes}
    for one, other in shapes.pairs:
        a, b = joint[one], joint[other]
        assert a != b
        assert robot.model.parents[a] != b
        assert robot.model.parents[b] != a


def test_the_distance_of_two_balls_is_that_of_their_centres_less_their_radii():
    robot = load_robot("a1")
    shapes = LinkShapes.of(robot)
    found = shapes.distances(robot.posture)[_pair(shapes, "FL_foot", "FR_foot")]
    radius = 0.02
    assert found == pytest.approx(
        np.linalg.norm(robot.feet[0] - robot.feet[1]) - 2 * radius, abs=1e-6
    )


def test_links_inside_each_other_have_a_negative_distance():
    robot = load_robot("a1")
    shapes = LinkShapes.of(robot)
    pair = _pair(shapes, "FL_foot", "FR_foot")
    inward = np.tile(robot.posture, (40, 1))
    for leg, sign in ((0, -1), (1, 1)):
        inward[:, robot.legs[leg].q_index[0]] += sign * np.linspace(0.0, 0.8, 40)
    found = shapes.distances(inward)[:, pair]
    assert found[0] > 0.1
    assert found.min() < -0.02  # the balls are 0.04 m wide


def test_the_least_distance_is_that_of_all():
    robot = load_robot("anymal")
    shapes = LinkShapes.of(robot)
    rng = np.random.default_rng(3)
    postures = np.tile(robot.posture, (60, 1))
    postures[:, 7:] += np.cumsum(rng.normal(scale=0.05, size=(60, 12)), axis=0)
    every = shapes.distances(postures)
    for first in (0, 20, 40):  # apart, and inside each other
        here = slice(first, first + 20)
        least, instant, pair = shapes.least(postures[here])
        assert least == pytest.approx(every[here].min(), abs=1e-5)
        assert every[here][instant, shapes.pairs.index(pair)] == pytest.approx(least, abs=1e-5)
    assert every.min() < 0 < every[:20].min()


def test_links_that_stand_nearer_than_they_should_be_are_to_be_half_as_far_apart():
    robot = load_robot("a1")
    shapes = LinkShapes.of(robot)
    pair = _pair(shapes, "FL_foot", "FR_foot")
    inward = np.tile(robot.posture, (400, 1))
    for leg, sign in ((0, -1), (1, 1)):
        inward[:, robot.legs[leg].q_index[0]] += sign * np.linspace(0.2, 0.4, 400)
    distance = shapes.distances(inward)[:, pair]
    k = int(np.argmin(np.abs(distance - 0.006)))
    near = LinkShapes(replace(robot, posture=inward[k]), shapes.shapes, shapes.pairs)
    assert near.apart[pair] == pytest.approx(distance[k] / 2)
    assert shapes.apart[pair] == 0.005
    # Of two that are as near, the one that is to be farther apart is the nearest.
    least, _, found = near.least(inward[k : k + 1], near.apart)
    every = near.distances(inward[k]) - near.apart
    assert near.pairs.index(found) == every.argmin()
    assert least == pytest.approx(every.min() + near.apart[every.argmin()], abs=1e-6)


def test_distances_do_not_depend_on_where_the_base_is():
    robot = load_robot("slider")
    shapes = LinkShapes.of(robot)
    moved = robot.posture.copy()
    moved[:3] += (3.0, -2.0, 1.0)
    moved[3:7] = np.array([0.1, 0.5, -0.3, 0.8]) / np.linalg.norm([0.1, 0.5, -0.3, 0.8])
    assert shapes.distances(moved) == pytest.approx(shapes.distances(robot.posture), abs=1e-5)


def test_a_mesh_is_a_hull_of_few_points_that_loses_little_more_than_a_millimetre():
    robot = load_robot("go2")
    hulls = [shape for shape in link_shapes(robot) if shape.kind == "hull"]
    meshes = collision_shapes(robot)
    for hull, mesh in zip(hulls, meshes, strict=False):
        if "calf" in hull.link:  # ends before the foot
            continue
        vertices = mesh.vertices
        planes = ConvexHull(hull.points).equations
        assert (vertices @ planes[:, :3].T + planes[:, 3]).max() < 1.5e-3
        assert len(hull.points) <= 150


@pytest.mark.parametrize("name", ["anymal", "go2"])
def test_the_ground_meets_the_ball_before_the_shin(name):
    """A robot stands on balls that are a fifth flattened, and no other link is as low."""
    robot = load_robot(name)
    lowest = min(robot.feet[:, 2]) - 0.8 * foot_contacts(robot)[0].radius
    ground = coal.Halfspace(np.array([0.0, 0.0, 1.0]), float(lowest))
    there = pin.SE3.Identity()
    assert LinkShapes.of(robot).clearance(robot.posture[None], ground, there)[0] > 0


def test_shapes_and_pairs_from_the_cache_are_those_that_were_made(tmp_path, monkeypatch):
    monkeypatch.setenv("LLSRBM_CACHE", str(tmp_path))
    path = tmp_path / "go2.toml"
    path.write_text(robot_files()["go2"].read_text())
    made = LinkShapes.of(load_robot(str(path)))
    path.write_text(path.read_text() + "\n")  # another object, the same key
    again = LinkShapes.of(load_robot(str(path)))
    assert again is not made
    assert again.pairs == made.pairs
    for one, other in zip(made.shapes, again.shapes, strict=True):
        assert (one.link, one.joint, one.kind, one.foot) == (
            other.link,
            other.joint,
            other.kind,
            other.foot,
        )
        assert np.array_equal(one.points, other.points)


def test_a_file_adds_and_excludes_pairs(tmp_path):
    path = tmp_path / "a1.toml"
    path.write_text(
        f'{A1}\n[link_pairs]\nadd = [["trunk", "FL_hip"]]\nexclude = [["FR_foot", "FL_foot"]]\n'
    )
    before = {frozenset(pair) for pair in LinkShapes.of(load_robot("a1")).pairs}
    after = {frozenset(pair) for pair in LinkShapes.of(load_robot(str(path))).pairs}
    assert after - before == {frozenset(("trunk", "FL_hip"))}
    assert before - after == {frozenset(("FL_foot", "FR_foot"))}


def test_a_link_that_is_not_there_is_named(tmp_path):
    path = tmp_path / "a1.toml"
    path.write_text(f'{A1}\n[link_pairs]\nadd = [["trunk", "FL_shin"]]\n')
    with pytest.raises(RobotFileError, match=r'link_pairs\.add: no link "FL_shin"'):
        LinkShapes.of(load_robot(str(path)))


def test_what_is_fixed_to_a_sole_stands_as_it_does(tmp_path):
    toe = """<link name="toe"><collision><origin xyz="0.08 0 -0.04"/><geometry>
    <box size="0.02 0.02 0.01"/></geometry></collision></link><joint name="toe_mount" type="fixed">
    <parent link="left_foot"/><child link="toe"/></joint></robot>"""
    path = robot_files()["slider"]
    file = read_robot_file(path)
    urdf = find_urdf(file, path).read_text()
    (tmp_path / "toed.urdf").write_text(urdf.replace("</robot>", toe))
    own = path.read_text().replace(f'file = "{file.urdf.file}"', 'file = "toed.urdf"')
    (tmp_path / "toed.toml").write_text(own.replace('name = "slider"', 'name = "toed"'))
    shapes = link_shapes(load_robot(str(tmp_path / "toed.toml")))
    assert {s.link for s in shapes if s.foot} == {"left_foot", "right_foot", "toe"}
