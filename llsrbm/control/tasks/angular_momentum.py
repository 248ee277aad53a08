"""The angular momentum follows the plan."""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dgesv

from llsrbm.control.reference import Target
from llsrbm.control.tasks.base import Motion, Task
from llsrbm.control.whole_body import WholeBody

_NONE, _IDENTITY = np.zeros(3), np.eye(3)


class AngularMomentum(Task):
    """Average angular velocity I^-1 L, rad/s, a coordinate of first order; I is the whole body's.

    The reference is the plan's own angular momentum, which on jumps is far from zero. Divided by
    the inertia, the same weight means the same for a robot of 15 kg and one of 30, and about all
    axes.
    """

    rows = 3

    def __init__(self, decay: float) -> None:
        """Decay of the error, 1/s."""
        super().__init__((0.0, decay))

    def motion(self, body: WholeBody, target: Target) -> Motion:
        """See `Task.motion`."""
        per_inertia = dgesv(body.inertia, _IDENTITY)[2]
        return Motion(
            per_inertia.dot(body.momentum_matrix[3:]),
            per_inertia.dot(body.momentum_bias[3:]),
            _NONE,
            per_inertia.dot(target.angular_momentum - body.angular_momentum),
            per_inertia.dot(target.angular_momentum_rate),
        )
