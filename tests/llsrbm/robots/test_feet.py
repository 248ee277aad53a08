"""Feet as the URDF's collision spheres, against the URDF's own text."""

import xml.etree.ElementTree as ET

import coal
import numpy as np
import pinocchio as pin
import pytest
import trimesh

from llsrbm.errors import RobotFileError
from llsrbm.robots import load_robot
from llsrbm.robots.feet import foot_contacts
from llsrbm.robots.schema import robot_files
from llsrbm.robots.shapes import link_shapes
from tests.llsrbm.simulation.sliding_biped import sliding_biped


@pytest.mark.parametrize("name", ["anymal", "a1"])
def test_the_sphere_of_each_foots_link(name):
    robot = load_robot(name)
    links = {link.get("name"): link for link in ET.parse(robot.urdf_path).iter("link")}
    contacts = foot_contacts(robot)
    assert len(contacts) == len(robot.legs)
    for leg, contact in zip(robot.legs, contacts, strict=True):
        (shape,) = (
            shape
            for shape in links[leg.foot_frame].iter("collision")
            if shape.find("geometry/sphere") is not None
        )
        assert contact.radius == float(shape.find("geometry/sphere").get("radius"))
        assert contact.centres[0] == pytest.approx(
            [float(x) for x in shape.find("origin").get("xyz").split()], abs=1e-12
        )


@pytest.mark.parametrize("name", ["anymal", "go2", "solo12"])
def test_a_standing_foots_ball_is_as_low_as_its_collision_geometry(name):
    robot = load_robot(name)
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.posture)
    shapes = [shape for shape in link_shapes(robot) if shape.foot]
    for leg, contact in zip(robot.legs, foot_contacts(robot), strict=True):
        frame = robot.model.frames[leg.foot_frame_id]
        ball = data.oMf[leg.foot_frame_id].act(contact.centres[0])[2] - contact.radius
        lowest = min(_lowest(shape, data) for shape in shapes if shape.joint == frame.parentJoint)
        assert ball == pytest.approx(lowest, abs=2e-3)


def _lowest(shape, data):
    """M: the height of a shape's lowest point, by its distance to a floor far below."""
    placed, top = data.oMi[shape.joint], -1.0
    here = coal.Transform3s(placed.rotation @ shape.rotation, placed.act(shape.centre))
    floor = coal.Transform3s(np.eye(3), np.array([0.0, 0.0, top - 0.5]))
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    return top + coal.distance(
        shape.geometry(), here, coal.Box(10.0, 10.0, 1.0), floor, request, result
    )


def test_of_several_spheres_on_a_leg_the_one_next_to_the_foot(tmp_path):
    for contact in foot_contacts(sliding_biped(tmp_path)):
        assert contact.radius == 0.04
        assert contact.centres[0] == pytest.approx([0, 0, 0.03], abs=1e-12)


def test_feet_of_meshes_without_a_radius_are_refused(tmp_path):
    path = tmp_path / "solo12.toml"
    text = robot_files()["solo12"].read_text()
    path.write_text(text.replace("radius = ", "# radius = "))
    with pytest.raises(RobotFileError) as caught:
        foot_contacts(load_robot(str(path)))
    message = str(caught.value)
    assert "\n" not in message
    assert "solo12.toml: legs.FL.foot" in message
    assert '"FL_FOOT" has no collision sphere' in message
    assert "foot.radius" in message


def test_feet_of_meshes_become_balls_of_the_files_radius():
    """Go2's: about the foot frame, as large as the mesh is below it within 2 mm."""
    for contact in foot_contacts(load_robot("go2")):
        assert contact.radius == 0.022
        assert contact.centres.tolist() == [[0, 0, 0]]
    mesh = next(load_robot("go2").urdf_path.parents[1].glob("collisions/foot_convex.stl"))
    assert -trimesh.load_mesh(mesh).bounds[0][2] == pytest.approx(0.022, abs=2e-3)
