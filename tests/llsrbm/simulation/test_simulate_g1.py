"""The humanoid, whose soles' spheres lie further ahead than the places that plans give its feet."""

import numpy as np
import pinocchio as pin

from llsrbm.motion.whole_body import pinocchio_states
from llsrbm.request.scenario import Scenario
from llsrbm.robots import load_robot
from llsrbm.simulation.simulate import simulate
from tests.llsrbm.library.shipped_motions import plan


def test_its_soles_land_where_they_are_planned_to():
    planned, robot = plan("g1-together-0001"), load_robot("g1")
    rollout = simulate(planned, robot, Scenario())
    np.testing.assert_allclose(rollout.foot_position[0], planned.foot_position[0], atol=1e-3)
    q, _ = pinocchio_states(rollout.qpos[-1:], rollout.qvel[-1:])
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q[0])
    soles = np.array([data.oMf[leg.foot_frame_id].translation for leg in robot.legs])
    np.testing.assert_allclose(rollout.foot_position[-1], soles, atol=1e-3)
    off = np.linalg.norm((soles - planned.foot_position[-1])[:, :2], axis=1)
    assert off.max() < 8e-3
    np.testing.assert_allclose(rollout.outcome.foot_error, off.max(), atol=1e-3)
