"""Check of the whole body's dynamics: nothing but its contacts and gravity moves the robot."""

import numpy as np

from llsrbm.certificate.finding import Check
from llsrbm.certificate.sampled_motion import NO_FORCES, SampledMotion
from llsrbm.motion.rollout import Rollout

ARM = 0.2  # m: a moment of ARM m g is as bad as a force of m g
SHARE = 0.1  # of both that may be missing


class Dynamics(Check):
    """The six rows of the floating base, which has no drive, of M a + h - J^T f.

    worst = max(|F| / (m g), |M| / (0.2 m x m g)), F the force (N) and M the moment (Nm) about the
    base's origin that the motion lacks; a tenth is allowed. In a rollout with soles the forces
    alone are known, not where they act, and M is left out. `limit`: the weight.
    """

    name, unit = "dynamics", "N"

    def take(self, motion: SampledMotion) -> None:
        """The largest remainder, force or moment."""
        if motion.effort is None:
            self.unknown(NO_FORCES)
            return
        if isinstance(motion.source, Rollout) and motion.source.pushes:
            self.unknown("pushes act beside the contacts")
            return
        force, moment = (np.linalg.norm(motion.effort[:, rows], axis=1) for rows in _ROWS)
        weight = motion.weight
        shares = np.column_stack([force / weight, moment / (ARM * weight)])
        if motion.whole_feet:
            shares[:, 1] = 0.0
        self.largest(motion, shares, weight, ("force", "moment"), allowed=SHARE)


_ROWS = slice(0, 3), slice(3, 6)
