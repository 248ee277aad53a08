"""What a robot in the simulation can stand on, or run into: boxes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Block:
    """A box that stands in the world for a while.

    Attributes:
        name: what it is.
        centre: (3,) m, world frame; size: (3,) m, full lengths along its own axes.
        yaw: rad, of its own axes about the vertical.
        from_s, until_s: when it stands there, s.
        untouched: whether a robot that touches it has failed.
    """

    name: str
    centre: Array
    size: Array
    yaw: float
    from_s: float = 0.0
    until_s: float = math.inf
    untouched: bool = False
