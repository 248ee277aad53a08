"""Orders, poses and velocities of bodies, held against MuJoCo."""

import pytest

from llsrbm.motion.bodies import body_order
from llsrbm.robots import load_robot
from tests.llsrbm.formats.jumps import ROBOTS, mujoco_model


@pytest.mark.parametrize("name", ROBOTS)
def test_depth_first_is_what_mujoco_has(name):
    model = mujoco_model(name)
    robot = load_robot(name)
    order = body_order(robot, "depth-first")
    bodies = [model.body(i).name for i in range(1, model.nbody)]
    assert [body for body in bodies if not body.startswith("world/")] == list(order.bodies)
    assert [model.joint(i).name for i in range(1, model.njnt)] == list(order.joints)
    assert [robot.joint_names[i] for i in order.index] == list(order.joints)


def test_breadth_first_is_what_isaac_lab_has():
    """As its users print it for ANYmal (IsaacLab issue 270)."""
    order = body_order(load_robot("anymal"), "breadth-first")
    legs = ("LF", "LH", "RF", "RH")
    joints = ("HAA", "HFE", "KFE")
    assert order.joints == tuple(f"{leg}_{joint}" for joint in joints for leg in legs)
    links = ("HIP", "THIGH", "SHANK")
    assert order.bodies == ("base", *(f"{leg}_{link}" for link in links for leg in legs))
