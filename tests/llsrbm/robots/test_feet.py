"""Feet as the URDF's collision spheres, against the URDF's own text."""

import xml.etree.ElementTree as ET

import pytest
import trimesh

from llsrbm.errors import RobotFileError
from llsrbm.robots import load_robot
from llsrbm.robots.feet import foot_contacts
from llsrbm.robots.schema import robot_files
from tests.llsrbm.simulation.sliding_biped import sliding_biped


@pytest.mark.parametrize("name", ["anymal", "a1", "anymal_c"])
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
