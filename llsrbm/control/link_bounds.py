"""Accelerations with which links that near each other stop before they touch.

As a joint short of its stop (`llsrbm.control.joint_bounds`), with the distance d between two links
in place of the joint's, d' = s v and d'' = s a + b of the joints, and what all drives together give
it: A = sum_j |s_j| `BRAKING` tau_j / M_jj.
"""

import numpy as np

from llsrbm.arrays import Array
from llsrbm.control.joint_bounds import least_acceleration
from llsrbm.control.whole_body import WholeBody
from llsrbm.robots import Robot
from llsrbm.robots.near_links import NearLinks

# Looked at are links that joints, as fast as they turn, could bring together within so long (s).
SOON = 0.02
# Share of the drives' torque: all of them rarely push the same way, and at 0.9 links have touched.
BRAKING = 0.5
LEAST = 0.002  # m that links keep apart; with 5 mm feet are kept from where plans land them


class LinkBounds:
    """Bounds on what joints do to the distances between a robot's links."""

    def __init__(self, robot: Robot) -> None:
        """Raises `RobotFileError`: the robot's geometry cannot be read."""
        self._links = NearLinks.of(robot)
        self._torque = BRAKING * robot.torque_limit

    def rows(self, body: WholeBody) -> tuple[Array, Array]:
        """S (k, J) and least (k,): S a >= least of the joints' accelerations a, rows of length 1.

        One row for each two limbs that are near each other, mostly none.
        """
        near = 2 * LEAST + SOON * self._links.fastest(body.v)
        found = self._links.at(body.data, body.q, near)
        if not found:
            return np.zeros((0, len(self._torque))), np.zeros(0)
        slopes = np.array([near.slope for near in found])
        left = np.array([near.distance for near in found]) - LEAST
        can = np.abs(slopes) @ (self._torque / body.M.diagonal()[6:])
        least = least_acceleration(left, slopes @ body.v[6:], can)
        close = np.flatnonzero(least > -can / BRAKING)  # others are farther than drives can drive
        drift = [found[k].acceleration(body.data) for k in close]
        length = np.linalg.norm(slopes[close], axis=1)
        return slopes[close] / length[:, None], (least[close] - drift) / length
