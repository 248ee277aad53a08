"""From where a robot is looked at."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from llsrbm.look.collision_visuals import visuals_at_once
from llsrbm.look.visuals import forward_kinematics, link_visuals
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]

_FROM = np.array([0.76, -1.17, 0.36])  # in the robot's size: from the right, ahead and above
_AT = np.array([0.1, 0.0, 0.04])  # likewise, from its middle: it will jump, mostly forward


@lru_cache(maxsize=8)
def viewpoint(robot: Robot, *, at_once: bool = False) -> tuple[Array, Array]:
    """Where the camera is and where it looks at, (3,) m, for a robot in its default posture.

    The robot fills the same part of the picture whatever its size, with room for a jump.
    `at_once`: by collision shapes rather than waiting for meshes that have to be prepared.
    """
    visuals = visuals_at_once(robot) if at_once else link_visuals(robot)
    position, wxyz = forward_kinematics(
        robot, robot.base_position[None], [[1.0, 0.0, 0.0, 0.0]], robot.posture[None, 7:]
    )
    turn = Rotation.from_quat(wxyz[0], scalar_first=True)
    points = np.concatenate(
        [
            turn[visual.joint_id - 1].apply(visual.vertices) + position[0, visual.joint_id - 1]
            for visual in visuals
        ]
    )
    low, high = points.min(axis=0), points.max(axis=0)
    size = np.linalg.norm(high - low)
    target = (low + high) / 2 + size * _AT
    return target + size * _FROM, target
