"""A default posture that stands on soles: they lie flat, and the CoM is above what they span."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import ConvexHull

from llsrbm.errors import RobotFileError

if TYPE_CHECKING:
    from llsrbm.robots.robot import Robot

_LEVEL = 0.01  # rad by which soles may lean: joint angles in a file are rounded


def check_soles(robot: Robot) -> None:
    """The default posture stands on its soles.

    Raises:
        RobotFileError: a sole leans, or the robot would tip over.
    """
    rotation = robot.foot_rotation
    for leg, upward in zip(robot.legs, rotation[..., 2], strict=True):
        lean = np.arctan2(np.hypot(upward[0], upward[1]), upward[2])
        if lean > _LEVEL:
            raise RobotFileError(
                f"{robot.path}: posture.{leg.name}: the sole {leg.foot_frame} leans by "
                f"{lean:.3f} rad; expected it level within {_LEVEL} rad"
            )
    points = robot.feet[:, None] + robot.corners @ np.swapaxes(rotation, -1, -2)
    edges = ConvexHull(points.reshape(-1, 3)[:, :2]).equations
    outside = edges[:, 2].max()  # of the origin, which is below the CoM
    if outside > 0:
        x, y, _ = points.mean(axis=(0, 1))
        raise RobotFileError(
            f"{robot.path}: posture: the robot tips over, its CoM is {outside:.3f} m outside what "
            f"its soles span, their middle {x:+.3f} m forward and {y:+.3f} m left of it; "
            "expected the CoM above them"
        )
