"""The base's attitude follows the plan."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from llsrbm.control.reference import Target
from llsrbm.control.tasks.base import Motion, Task
from llsrbm.control.whole_body import WholeBody

_NONE = np.zeros(3)


class BaseOrientation(Task):
    """Attitude of the base, rad: AngleAxis(R_wanted R^T), world axes."""

    rows = 3

    def motion(self, body: WholeBody, target: Target) -> Motion:
        """See `Task.motion`."""
        jacobian = np.zeros((3, body.velocities))
        # The base's own angular velocity, turned into the world; it turns with itself: no bias.
        jacobian[:, 3:6] = body.R_world_base
        return Motion(
            jacobian,
            _NONE,
            pin.log3(target.R_world_base @ body.R_world_base.T),
            target.angular_velocity - body.angular_velocity,
            target.angular_acceleration,
        )
