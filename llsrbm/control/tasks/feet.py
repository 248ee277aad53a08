"""Feet: in the air they go where the plan wants them, on the ground they stay."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from llsrbm.control.reference import Target
from llsrbm.control.tasks.base import Motion, Task
from llsrbm.control.whole_body import WholeBody

_DOWNWARDS = np.array([0.0, 0.0, -0.5])
"""How a foot that still is in the air after touchdown of another seeks the ground, m/s."""


class SwingFeet(Task):
    """Positions of some feet's lowest points relative to the CoM, m, world axes.

    Relative, because in flight the CoM falls freely: a foot held to a place in the world would stop
    reaching for the ground when the robot arrives late.
    """

    def __init__(self, feet: Sequence[int], gains: tuple[float, float]) -> None:
        """For the feet of those indices."""
        super().__init__(gains)
        self._feet = _places(feet)
        self.rows = 3 * len(feet)

    def motion(self, body: WholeBody, target: Target) -> Motion:
        """See `Task.motion`; the CoM accelerates as the target says: in flight with gravity."""
        i = self._feet
        error = target.foot_from_com[i] - (body.foot[i] - body.com)
        error_rate = target.foot_velocity_from_com[i] - (body.foot_velocity[i] - body.com_velocity)
        return Motion(
            body.foot_jacobian[i].reshape(self.rows, -1),
            body.foot_bias[i].ravel(),
            error.ravel(),
            error_rate.ravel(),
            (target.foot_acceleration_from_com[i] + target.com_acceleration).ravel(),
        )


class SeekingFeet(Task):
    """Velocities of feet that look for the ground while others stand, m/s."""

    def __init__(self, feet: Sequence[int], damping: float) -> None:
        """For the feet of those indices; damping in 1/s."""
        super().__init__((0.0, damping))
        self._feet = _places(feet)
        self.rows = 3 * len(feet)
        self._none = np.zeros(self.rows)

    def motion(self, body: WholeBody, target: Target) -> Motion:
        """See `Task.motion`."""
        i = self._feet
        return Motion(
            body.foot_jacobian[i].reshape(self.rows, -1),
            body.foot_bias[i].ravel(),
            self._none,
            (_DOWNWARDS - body.foot_velocity[i]).ravel(),
            self._none,
        )


class StandingFeet(Task):
    """The points of feet that touch the ground come to rest: a soft contact constraint.

    Some damping brings feet back that bounce, and soles to lie flat; much of it fights the impact.
    """

    def __init__(self, feet: Sequence[int], points: int, damping: float) -> None:
        """For the feet of those indices with that many points each; damping in 1/s."""
        super().__init__((0.0, damping))
        self._points = _places([foot * points + j for foot in feet for j in range(points)])
        self.rows = 3 * points * len(feet)
        self._none = np.zeros(self.rows)

    def motion(self, body: WholeBody, target: Target) -> Motion:
        """See `Task.motion`."""
        i = self._points
        return Motion(
            body.contact_jacobian[i].reshape(self.rows, -1),
            body.contact_bias[i].ravel(),
            self._none,
            -body.contact_velocity[i].ravel(),
            self._none,
        )


def _places(indices: Sequence[int]) -> slice | NDArray[np.intp]:
    """What selects them: where they follow each other a slice, which copies nothing."""
    first, last = indices[0], indices[-1]
    if list(indices) == list(range(first, last + 1)):
        return slice(first, last + 1)
    return np.array(indices)
