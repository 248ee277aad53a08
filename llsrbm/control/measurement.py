"""All that a controller may know of the world."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Measurement:
    """What sensors and estimators say at the beginning of a tick.

    Attributes:
        time: s since the plan's start.
        q: (nq,) and v: (nv,), estimated, Pinocchio's conventions.
        torque: (J,) Nm or N, measured, mean of the tick that ended.
    """

    time: float
    q: Array
    v: Array
    torque: Array
