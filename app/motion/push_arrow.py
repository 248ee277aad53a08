"""The arrow of a push: where it begins, and how long it is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from app.motion.frames import Frames
from llsrbm.mechanics import rotation_matrices
from llsrbm.robots import Robot

Array = NDArray[np.float64]

ARROW_PER_SPEED = 2.0
"""Length of the arrow of a push that gives the robot 1 m/s, m: such as matter reach out of it."""


def trunk_com(robot: Robot, frames: Frames) -> Array:
    """The trunk's own CoM (F, 3) m, on which pushes act."""
    turn = rotation_matrices(frames.body_wxyz[:, 0])
    arm = robot.model.inertias[1].lever
    return np.asarray(frames.body_position[:, 0] + turn @ arm)


def metres_per_newton_second(robot: Robot) -> float:
    """Length of a push's arrow over its impulse."""
    return ARROW_PER_SPEED / float(robot.mass)
