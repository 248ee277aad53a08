"""A plan or a rollout as viewers and pictures show it: its bodies, and what stands around."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from llsrbm.analysis.inertia_ellipsoid import ellipsoid
from llsrbm.look.visuals import LinkVisual, forward_kinematics
from llsrbm.mechanics import rotation_matrices, sign_continuous
from llsrbm.motion.plan import Plan
from llsrbm.motion.trajectory import Trajectory
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.request.scenario import Scenario
from llsrbm.robots import Robot
from llsrbm.simulation.surroundings import Surroundings, surroundings

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Bodies:
    """Where a robot's B moving bodies are, in Pinocchio's order of joints.

    Attributes:
        position: (K, B, 3) m, world frame; quat: (K, B, 4) w, x, y, z.
    """

    position: Array
    quat: Array

    @staticmethod
    def of(robot: Robot, state: Plan | WholeBodyMotion, joint_position: Array) -> Bodies:
        """With the base of a motion and joints in the robot's order."""
        return Bodies(
            *forward_kinematics(robot, state.base_position, state.base_quat, joint_position)
        )

    def poses(self, visuals: Sequence[LinkVisual]) -> Array:
        """(K, n, 7) of n meshes: position, quaternion without jumps of sign."""
        index = [visual.joint_id - 1 for visual in visuals]
        quat = np.stack([sign_continuous(self.quat[:, body]) for body in index], axis=1)
        return np.concatenate([self.position[:, index], quat], axis=2)


def mass_of(trajectory: Trajectory, robot: Robot) -> float:
    """Mass (kg) of what moved: that of the simulated trunk may be off."""
    return robot.mass if isinstance(trajectory, Plan) else trajectory.disturbance.mass(robot)


def ellipsoid_of(motion: WholeBodyMotion, mass: float) -> tuple[Array, Array]:
    """(K, 3) m and (K, 4): the uniform solid of the same mass and inertia, by the base's axes."""
    return ellipsoid(motion.inertia, mass, rotation_matrices(motion.base_quat))


def surroundings_of(trajectory: Trajectory, robot: Robot) -> Surroundings:
    """Ground and blocks, as far as they are known."""
    if isinstance(trajectory, Plan):
        return surroundings(robot, trajectory, Scenario())
    return surroundings(robot, trajectory.plan, trajectory.scenario)
