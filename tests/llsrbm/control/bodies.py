"""A robot in some state of motion, for tests of the controller."""

import numpy as np
import pinocchio as pin

from llsrbm.control.reference import Target
from llsrbm.control.whole_body import WholeBody
from llsrbm.robots import load_robot

ROBOTS = ("anymal", "slider")


def state(seed: int, name: str = "anymal") -> tuple[np.ndarray, np.ndarray]:
    robot = load_robot(name)
    rng = np.random.default_rng(seed)
    q = pin.integrate(robot.model, robot.posture, 0.3 * rng.standard_normal(robot.model.nv))
    return q, rng.standard_normal(robot.model.nv)


def moved(seed: int, acceleration: np.ndarray, dt: float, name: str = "anymal") -> WholeBody:
    """The body of `state(seed)`, dt later under a constant acceleration."""
    robot = load_robot(name)
    q, v = state(seed, name)
    body = WholeBody(robot)
    body.update(
        pin.integrate(robot.model, q, v * dt + acceleration * dt * dt / 2), v + acceleration * dt
    )
    return body


def resting_target(legs: int = 4, joints: int = 12) -> Target:
    """Everything at zero or as it stands."""
    zero = np.zeros(3)
    return Target(
        com=zero,
        com_velocity=zero,
        com_acceleration=zero,
        R_world_base=np.eye(3),
        angular_velocity=zero,
        angular_acceleration=zero,
        angular_momentum=zero,
        angular_momentum_rate=zero,
        contact_force=np.zeros((legs, 3)),
        foot_from_com=np.zeros((legs, 3)),
        foot_velocity_from_com=np.zeros((legs, 3)),
        foot_acceleration_from_com=np.zeros((legs, 3)),
        foot_heading=np.zeros((legs, 3)),
        joint_position=np.zeros(joints),
        joint_velocity=np.zeros(joints),
        joint_acceleration=np.zeros(joints),
    )
