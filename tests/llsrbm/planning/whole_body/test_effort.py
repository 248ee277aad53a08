"""Efforts of trunk and limbs, derived once for each kind of limb, against Pinocchio."""

import numpy as np
import pinocchio as pin
import pytest

from llsrbm.planning.whole_body.effort import limb_effort, trunk_effort
from llsrbm.planning.whole_body.limbs import limbs_of, trunk_numbers
from llsrbm.robots import load_robot, names
from tests.llsrbm.kinematics import links_alone, of_drives
from tests.llsrbm.planning.whole_body.moving import moving

UP = (0.0, 0.0, 1.0)


def of_pinocchio(robot, q, v, a, forces):
    """Base and drives, base axes: of links, forces (L, c, 3) N, world axes, and of drives."""
    model, data = links_alone(robot), robot.model.createData()
    effort = pin.rnea(model, data, q, v, a)
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    for leg, pushes in zip(robot.legs, forces, strict=True):
        J = pin.getFrameJacobian(model, data, leg.foot_frame_id, pin.LOCAL_WORLD_ALIGNED)
        arms = robot.corners @ data.oMf[leg.foot_frame_id].rotation.T - [0, 0, robot.foot_lift]
        effort -= J.T @ np.append(pushes.sum(axis=0), np.cross(arms, pushes).sum(axis=0))
    effort[6:] += of_drives(robot, v[6:], a[6:])
    return effort


@pytest.mark.parametrize("name", ["go2", "slider", "g1"])
@pytest.mark.parametrize("stands", [True, False])
def test_they_are_pinocchios(name, stands):
    robot = load_robot(name)
    state, q, v = moving(robot, 4)
    rng = np.random.default_rng(5)
    rates = rng.normal(size=3) * 5, rng.normal(size=3) * 20, rng.normal(size=robot.model.nv - 6) * 9
    acceleration, omega_rate, joints = rates
    forces = rng.normal(size=(len(robot.legs), len(robot.corners), 3)) * 50 * stands
    R = pin.Quaternion(q[3:7]).toRotationMatrix()
    # Pinocchio's is a spatial acceleration, in which the base's turning velocity is missing.
    linear = R.T @ acceleration - np.cross(v[3:6], v[:3])
    expected = of_pinocchio(robot, q, v, np.concatenate([linear, omega_rate, joints]), forces)

    base = [state["quat"], state["omega"], acceleration, omega_rate]
    found = np.zeros(robot.model.nv)
    trunk = trunk_effort().value(np.concatenate(base), trunk_numbers(robot))
    found[:6] = np.array(trunk).ravel()
    for i, limb in enumerate(limbs_of(robot)):
        own = list(limb.joints)
        inputs = [*base, state["joint_position"][own], state["joint_velocity"][own], joints[own]]
        standing = stands and i < len(robot.legs)
        inputs += [forces[i].ravel()] if standing else []
        numbers = np.append(limb.numbers, UP) if limb.kind.corners else limb.numbers
        effort = limb_effort(limb.kind, standing).value(np.concatenate(inputs), numbers)
        found[:6] += np.array(effort).ravel()[:6]
        found[[6 + joint for joint in own]] = np.array(effort).ravel()[6:]
    np.testing.assert_allclose(found, expected, atol=1e-8)


def test_quadrupeds_of_the_same_build_share_their_expressions():
    kinds = {name: {limb.kind for limb in limbs_of(load_robot(name))} for name in names()}
    assert len(kinds["go2"]) == 1
    assert kinds["go2"] == kinds["a1"] == kinds["go1"] == kinds["anymal"]
