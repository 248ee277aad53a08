"""Attitudes follow the plan: the base's, and those of soles in the air."""

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


class FootOrientation(Task):
    """Attitude of a foot, rad, world axes: level, with the plan's heading.

    Relative to the world, because that is how soles shall meet the ground.
    """

    rows = 3

    def __init__(self, foot: int, gains: tuple[float, float]) -> None:
        """For the foot of that index."""
        super().__init__(gains)
        self._foot = foot

    def motion(self, body: WholeBody, target: Target) -> Motion:
        """See `Task.motion`."""
        i = self._foot
        heading, rate, acceleration = target.foot_heading[i]
        c, s = np.cos(heading), np.sin(heading)
        wanted = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        return Motion(
            body.foot_rotation_jacobian[i],
            body.foot_rotation_bias[i],
            pin.log3(wanted @ body.R_world_foot[i].T),
            np.array([0.0, 0.0, rate]) - body.foot_angular_velocity[i],
            np.array([0.0, 0.0, acceleration]),
        )
