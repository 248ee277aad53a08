import logging
import re

import numpy as np
import pinocchio as pin
import pytest

from llsrbm.cache import ENVIRONMENT_VARIABLE
from llsrbm.errors import RobotFileError
from llsrbm.look.visuals import FACES, forward_kinematics, link_visuals
from llsrbm.robots import build_robot, load_robot
from llsrbm.robots.feet import collision_shapes
from tests.llsrbm.look.standing import standing
from tests.llsrbm.robots.test_robot import beside


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    """One cache for all tests of this file: the meshes are prepared once."""
    directory = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(ENVIRONMENT_VARIABLE, str(directory))
        yield directory


@pytest.fixture(scope="module")
def anymal(cache):
    return link_visuals(load_robot("anymal"))


def test_every_moving_body_is_one_light_mesh(anymal):
    assert [visual.joint_id for visual in anymal] == list(range(1, 14))
    assert anymal[0].link == "base"
    assert 0.5 * FACES < sum(len(visual.faces) for visual in anymal) < 1.2 * FACES
    assert sum(len(visual.mesh().export(file_type="glb")) for visual in anymal) < 2e6
    for visual in anymal:
        assert visual.vertices.dtype == np.float32
        assert visual.rgb.shape == visual.vertices.shape == visual.normals.shape
        assert visual.faces.max() < len(visual.vertices)
        assert np.linalg.norm(visual.normals, axis=1) == pytest.approx(1, abs=0.03)


def test_meshes_sit_where_the_robot_is(anymal):
    """Drawn standing: the soles at the ground, the body's outline as wide as it is."""
    robot = load_robot("anymal")
    everything = standing(robot, anymal)
    assert everything[:, 2].min() == pytest.approx(0, abs=0.02)
    assert 0.5 < everything[:, 2].max() < 0.9
    low = everything[everything[:, 2] < 0.03]
    for foot in robot.feet:
        assert np.linalg.norm(low - foot, axis=1).min() < 0.04


def test_meshes_come_from_the_cache_and_survive_damage(anymal, cache, monkeypatch, caplog):
    robot = load_robot("anymal")
    with monkeypatch.context() as patch:
        patch.setattr("llsrbm.look.visuals._prepare", None)
        again = link_visuals(robot)
    for one, other in zip(anymal, again, strict=True):
        assert (one.link, one.joint_id) == (other.link, other.joint_id)
        for name in ("vertices", "normals", "faces", "rgb"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    (entry,) = cache.glob("visuals-*/*.npz")
    entry.write_bytes(entry.read_bytes()[:-100])
    monkeypatch.setattr("llsrbm.look.visuals._prepare", lambda *_: anymal)
    with caplog.at_level(logging.WARNING):
        assert len(link_visuals(robot)) == len(anymal)
    assert "damaged" in caplog.text


def test_poses_over_time_are_pinocchios():
    robot = load_robot("go2")
    rng = np.random.default_rng(5)
    base, joints = rng.normal(size=(6, 3)), rng.uniform(-2, 2, size=(6, 12))
    quats = rng.normal(size=(6, 4))
    quats /= np.linalg.norm(quats, axis=1, keepdims=True)
    position, quat = forward_kinematics(robot, base, quats, joints)
    data = robot.model.createData()
    for k in range(6):
        q = np.concatenate([base[k], quats[k, 1:], quats[k, :1], joints[k]])
        pin.forwardKinematics(robot.model, data, q)
        for joint in range(1, robot.model.njoints):
            truth = data.oMi[joint]
            np.testing.assert_allclose(position[k, joint - 1], truth.translation, atol=1e-12)
            w, x, y, z = quat[k, joint - 1]
            np.testing.assert_allclose(
                pin.Quaternion(w, x, y, z).matrix(), truth.rotation, atol=1e-12
            )


PRIMITIVES = """
<robot name="drawn">
  <material name="red"><color rgba="1 0 0 1"/></material>
  <link name="base"><visual><geometry>{shape}</geometry><material name="red"/></visual>
    <inertial><mass value="5"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  {legs}
</robot>
"""
LEG = """
  <joint name="{n}_A" type="revolute"><parent link="base"/><child link="{n}_a"/>
    <origin xyz="{x} {y} 0"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
  <link name="{n}_a"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="{n}_foot" type="fixed"><parent link="{n}_a"/><child link="{n}_FOOT"/>
    <origin xyz="0 0 -0.4"/></joint>
  <link name="{n}_FOOT"/>
"""


def drawn_robot(tmp_path, shape):
    places = {"LF": (1, 1), "RF": (1, -1), "LH": (-1, 1), "RH": (-1, -1)}
    legs = "".join(LEG.format(n=name, x=x, y=y) for name, (x, y) in places.items())
    path = beside(tmp_path, PRIMITIVES.format(shape=shape, legs=legs))
    text = path.read_text().replace("_HFE", "_A")
    for angles in ("-0.1, 0.7, -1.0", "0.1, 0.7, -1.0", "-0.1, -0.7, 1.0", "0.1, -0.7, 1.0"):
        text = text.replace(f"[{angles}]", "[0.0]")
    path.write_text(text + "\n[foot]\nradius = 0.02\n")
    return build_robot(path)


def test_primitives_keep_the_urdfs_colour(tmp_path, cache):
    robot = drawn_robot(tmp_path, '<box size="0.4 0.2 0.1"/>')
    (base,) = link_visuals(robot)
    assert base.link == "base"
    assert len(base.faces) == 12
    assert (base.rgb == [255, 0, 0]).all()
    np.testing.assert_allclose(np.ptp(base.vertices, axis=0), [0.4, 0.2, 0.1], atol=2e-4)


def test_a_missing_mesh_is_named(tmp_path, cache):
    with pytest.raises(RobotFileError, match=r'mesh "package://nosuch/base\.dae" is missing'):
        drawn_robot(tmp_path, '<mesh filename="package://nosuch/base.dae"/>')


def test_a_robot_without_meshes_is_drawn_by_its_collision_shapes(tmp_path, cache):
    path = beside(tmp_path, load_robot("anymal").urdf_path.read_text())
    text = re.sub(r"<visual>.*?</visual>", "", (tmp_path / "robot.urdf").read_text(), flags=re.S)
    (tmp_path / "robot.urdf").write_text(text)
    robot = build_robot(path)
    shapes = {shape.joint for shape in collision_shapes(robot)}
    assert {visual.joint_id for visual in link_visuals(robot)} == shapes
    (tmp_path / "robot.urdf").write_text(
        re.sub(r"<collision>.*?</collision>", "", text, flags=re.S)
    )
    path.write_text(path.read_text() + "\n[foot]\nradius = 0.02\n")
    with pytest.raises(RobotFileError, match="neither visual nor collision shapes"):
        link_visuals(build_robot(path))


def test_coarse_meshes_are_the_same_bodies_with_far_fewer_faces(anymal):
    """Where a robot is seen, it is seen coarsely, too: outlines within 2 cm, and no holes."""
    coarse = link_visuals(load_robot("anymal"), coarse=True)
    assert [v.link for v in coarse] == [v.link for v in anymal]
    assert sum(len(v.faces) for v in coarse) < 0.43 * sum(len(v.faces) for v in anymal)
    for fine, few in zip(anymal, coarse, strict=True):
        corners = [(v.vertices.min(axis=0), v.vertices.max(axis=0)) for v in (fine, few)]
        assert np.abs(np.subtract(*corners)).max() < 0.02, fine.link
        # A tenth of the surface is in details; what is torn loses far more.
        assert few.mesh().area > 0.6 * fine.mesh().area, fine.link
        assert np.linalg.norm(few.normals, axis=1) == pytest.approx(1.0, abs=0.05)
