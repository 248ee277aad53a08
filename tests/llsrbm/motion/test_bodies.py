"""Orders, poses and velocities of bodies, held against MuJoCo."""

import mujoco
import numpy as np
import pytest

from llsrbm.motion.bodies import body_motion, body_order
from llsrbm.motion.whole_body import whole_body_motion
from llsrbm.robots import load_robot
from tests.llsrbm.formats.jumps import ROBOTS, mujoco_model, replayed, same_attitude, simulated


@pytest.mark.parametrize("name", ROBOTS)
def test_depth_first_is_what_mujoco_has(name):
    model = mujoco_model(name)
    robot = load_robot(name)
    order = body_order(robot, "depth-first")
    bodies = [model.body(i).name for i in range(1, model.nbody)]
    assert [body for body in bodies if not body.startswith("world/")] == list(order.bodies)
    assert [model.joint(i).name for i in range(1, model.njnt)] == list(order.joints)
    assert [robot.joint_names[i] for i in order.joint_index] == list(order.joints)


def test_breadth_first_is_what_isaac_lab_has():
    """As its users print it for ANYmal (IsaacLab issue 270)."""
    order = body_order(load_robot("anymal"), "breadth-first")
    legs = ("LF", "LH", "RF", "RH")
    joints = ("HAA", "HFE", "KFE")
    assert order.joints == tuple(f"{leg}_{joint}" for joint in joints for leg in legs)
    links = ("HIP", "THIGH", "SHANK")
    assert order.bodies == ("base", *(f"{leg}_{link}" for link in links for leg in legs))


def link(name):
    return f'<link name="{name}"/>'


def joint(name, parent, child, kind="revolute"):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
    )


class Scrambled:
    """A URDF whose links and joints stand in no order, one leg hanging on a welded link."""

    joint_names = ("a1", "a2", "m1", "w1", "z1")
    text = (
        '<robot name="scrambled">'
        + "".join(map(link, ("z", "weld", "a", "w", "aa", "m", "tip", "base")))
        + joint("a2", "a", "aa")
        + joint("m1", "base", "m")
        + joint("tip_mount", "m", "tip", "fixed")
        + joint("weld_mount", "base", "weld", "fixed")
        + joint("a1", "base", "a")
        + joint("w1", "weld", "w")
        + joint("z1", "base", "z")
        + "</robot>"
    )

    def __init__(self, folder):
        self.urdf_path = folder / "scrambled.urdf"
        self.urdf_path.write_text(self.text)


def test_links_welded_to_the_base_and_joints_in_any_order(tmp_path):
    robot = Scrambled(tmp_path)
    spec = mujoco.MjSpec.from_string(robot.text)
    spec.worldbody.first_body().add_freejoint()
    for body in spec.bodies[1:]:
        body.explicitinertial, body.mass, body.inertia = True, 1.0, [1.0, 1.0, 1.0]
    model = spec.compile()
    order = body_order(robot, "depth-first")
    assert [model.body(i).name for i in range(1, model.nbody)] == list(order.bodies)
    assert [model.joint(i).name for i in range(1, model.njnt)] == list(order.joints)
    breadth = body_order(robot, "breadth-first")
    assert breadth.bodies == ("base", "a", "m", "w", "z", "aa")
    assert breadth.joints == ("a1", "m1", "w1", "z1", "a2")


@pytest.mark.parametrize("order", ["depth-first", "breadth-first"])
@pytest.mark.parametrize("name", ROBOTS)
def test_poses_and_velocities_are_mujocos(name, order):
    motion = whole_body_motion(simulated(name), fps=40)
    bodies = body_motion(motion, order)
    position, quat, velocity, com_velocity, angular = replayed(
        name, motion.robot.joint_names, motion.qpos, motion.qvel, bodies.order.bodies
    )
    np.testing.assert_allclose(bodies.position, position, atol=1e-9)
    same_attitude(bodies.quat, quat, atol=1e-9)
    np.testing.assert_allclose(bodies.velocity, velocity, atol=1e-8)
    np.testing.assert_allclose(bodies.com_velocity, com_velocity, atol=1e-8)
    np.testing.assert_allclose(bodies.angular_velocity, angular, atol=1e-8)
    assert (np.sum(bodies.quat[1:] * bodies.quat[:-1], axis=-1) > 0.5).all()
    assert np.abs(bodies.velocity - bodies.com_velocity).max() > 0.1  # they are two things
