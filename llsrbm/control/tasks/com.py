"""The CoM follows the plan."""

from __future__ import annotations

from llsrbm.control.reference import Target
from llsrbm.control.tasks.base import Motion, Task
from llsrbm.control.whole_body import WholeBody


class CentreOfMass(Task):
    """Position of the CoM, m; its Jacobian is the linear part of the momentum matrix."""

    rows = 3

    def motion(self, body: WholeBody, target: Target) -> Motion:
        """See `Task.motion`."""
        return Motion(
            body.momentum_matrix[:3] / body.mass,
            body.momentum_bias[:3] / body.mass,
            target.com - body.com,
            target.com_velocity - body.com_velocity,
            target.com_acceleration,
        )
