"""Joints stay near the plan's posture where nothing else wants them."""

from __future__ import annotations

import numpy as np

from llsrbm.control.reference import Target
from llsrbm.control.tasks.base import Motion, Task
from llsrbm.control.whole_body import WholeBody


class Posture(Task):
    """Joint positions, rad or m; with a small weight it makes the quadratic program definite."""

    def __init__(self, joints: int, gains: tuple[float, float]) -> None:
        """For all joints."""
        super().__init__(gains)
        self.rows = joints
        self._jacobian = np.eye(joints, joints + 6, k=6)
        self._bias = np.zeros(joints)

    def motion(self, body: WholeBody, target: Target) -> Motion:
        """See `Task.motion`."""
        return Motion(
            self._jacobian,
            self._bias,
            target.joint_position - body.q[7:],
            target.joint_velocity - body.v[6:],
            self._bias,
        )
