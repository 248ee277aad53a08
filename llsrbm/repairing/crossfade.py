"""From one motion over to another: bases and joints gradually, feet straight.

Angles in between would put the feet off the ground, so they are found by inverse kinematics of feet
that go straight from where they stand in one motion to where they stand in the other.
"""

from __future__ import annotations

import numpy as np

from llsrbm.arrays import Array
from llsrbm.body.momentum import centroidal_states
from llsrbm.body.postures import solve_postures
from llsrbm.mechanics import slerp
from llsrbm.motion.whole_body import pinocchio_states
from llsrbm.repairing.feet import feet_of
from llsrbm.robots.robot import Robot


def crossfaded(robot: Robot, start: Array, end: Array, share: Array) -> Array:
    """Postures (K, 7 + J) on the way from ones (K, 7 + J) to others, at shares (K,) of its time.

    MuJoCo's convention. Velocity and acceleration of the way are zero at shares 0 and 1.
    """
    gone = _smooth(share)
    straight = _between(start, end, gone)
    (feet, soles), (others, other_soles) = (feet_of(robot, qpos) for qpos in (start, end))
    feet = feet + gone[:, None, None] * (others - feet)
    q, v = pinocchio_states(straight, np.zeros((len(straight), straight.shape[1] - 1)))
    com, _, _ = centroidal_states(robot.model, q, v)
    soles = slerp(soles, other_soles, gone[:, None])
    found = solve_postures(robot, com, straight[:, 3:7], feet, soles, near=straight[:, 7:])
    return np.hstack([found.base_position, straight[:, 3:7], found.joint_position])


def _smooth(share: Array) -> Array:
    """From 0 to 1 with no velocity and no acceleration at both ends."""
    return share**3 * (10 - 15 * share + 6 * share**2)


def _between(start: Array, end: Array, gone: Array) -> Array:
    straight = start + gone[:, None] * (end - start)
    straight[:, 3:7] = slerp(start[:, 3:7], end[:, 3:7], gone)
    return straight
