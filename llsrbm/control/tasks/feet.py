"""Feet: in the air they go where the plan wants them, on the ground they stay."""

from __future__ import annotations

import numpy as np

from llsrbm.control.reference import Target
from llsrbm.control.tasks.base import Motion, Task
from llsrbm.control.whole_body import WholeBody

_NONE = np.zeros(3)
_DOWNWARDS = np.array([0.0, 0.0, -0.5])
"""How a foot that still is in the air after touchdown of another seeks the ground, m/s."""


class SwingFoot(Task):
    """Position of a foot's lowest point relative to the CoM, m, world axes.

    Relative, because in flight the CoM falls freely: a foot held to a place in the world would stop
    reaching for the ground when the robot arrives late.
    """

    rows = 3

    def __init__(self, foot: int, gains: tuple[float, float]) -> None:
        """For the foot of that index."""
        super().__init__(gains)
        self._foot = foot

    def motion(self, body: WholeBody, target: Target) -> Motion:
        """See `Task.motion`; the CoM accelerates as the target says: in flight with gravity."""
        i = self._foot
        return Motion(
            body.foot_jacobian[i],
            body.foot_bias[i],
            target.foot_from_com[i] - (body.foot[i] - body.com),
            target.foot_velocity_from_com[i] - (body.foot_velocity[i] - body.com_velocity),
            target.foot_acceleration_from_com[i] + target.com_acceleration,
        )


class SeekingFoot(Task):
    """Speed of a foot that looks for the ground while others stand, m/s."""

    rows = 3

    def __init__(self, foot: int, damping: float) -> None:
        """For the foot of that index; damping in 1/s."""
        super().__init__((0.0, damping))
        self._foot = foot

    def motion(self, body: WholeBody, target: Target) -> Motion:
        """See `Task.motion`."""
        i = self._foot
        return Motion(
            body.foot_jacobian[i],
            body.foot_bias[i],
            _NONE,
            _DOWNWARDS - body.foot_velocity[i],
            _NONE,
        )


class StandingFoot(Task):
    """The points of a foot that touch the ground come to rest: a soft contact constraint.

    Some damping brings feet back that bounce, and soles to lie flat; much of it fights the impact.
    """

    def __init__(self, foot: int, points: int, damping: float) -> None:
        """For the foot of that index with that many points; damping in 1/s."""
        super().__init__((0.0, damping))
        self._points = slice(foot * points, (foot + 1) * points)
        self.rows = 3 * points
        self._none = np.zeros(self.rows)

    def motion(self, body: WholeBody, target: Target) -> Motion:
        """See `Task.motion`."""
        points = self._points
        return Motion(
            body.contact_jacobian[points].reshape(self.rows, -1),
            body.contact_bias[points].ravel(),
            self._none,
            -body.contact_velocity[points].ravel(),
            self._none,
        )
