"""The angular momentum follows the plan."""

from __future__ import annotations

import numpy as np

from llsrbm.control.reference import Target
from llsrbm.control.tasks.base import Motion, Task
from llsrbm.control.whole_body import WholeBody

_NONE = np.zeros(3)


class AngularMomentum(Task):
    """Angular momentum about the CoM, kg m2/s, a coordinate of first order.

    The reference is the plan's own, which on jumps is far from zero.
    """

    rows = 3

    def __init__(self, decay: float) -> None:
        """Decay of the error, 1/s."""
        super().__init__((0.0, decay))

    def motion(self, body: WholeBody, target: Target) -> Motion:
        """See `Task.motion`."""
        return Motion(
            body.momentum_matrix[3:],
            body.momentum_bias[3:],
            _NONE,
            target.angular_momentum - body.angular_momentum,
            target.angular_momentum_rate,
        )
