"""Blocks: boxes, stones, bars and wedges that stand around the robot for a while."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from llsrbm.arrays import Array
from llsrbm.mechanics import quaternion_product, quaternions_about_z, rotation_matrices
from llsrbm.request.slopes import leaning


@dataclass(frozen=True, eq=False)
class Block:
    """A box that stands in the world for a while."""

    name: str  # of the box, unique
    centre: Array  # (3,) m, world frame
    size: Array  # (3,) m, full lengths along its own axes
    yaw: float  # rad, of its own axes about its upright one
    from_s: float = 0.0  # when it stands there, s
    until_s: float = math.inf  # when it stands there, s
    untouched: bool = False  # whether a robot that touches it has failed
    # Gradient of its top along the world's x and y axes, onto which it is turned the short way.
    tilt: tuple[float, float] = (0.0, 0.0)

    @property
    def quat(self) -> Array:
        """(4,) w, x, y, z: how its own axes are turned in the world."""
        leans = leaning(np.array(self.tilt))
        return quaternion_product(leans, quaternions_about_z(self.yaw))

    @property
    def rotation(self) -> Array:
        """(3, 3) R_world_block."""
        return rotation_matrices(self.quat)
