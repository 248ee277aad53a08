"""The stretch of a motion that was repaired, as it was, beside its plan."""

from __future__ import annotations

import numpy as np

from llsrbm.motion.whole_body import WholeBodyMotion, motion_of_states
from llsrbm.repairing.frame import Frame
from llsrbm.repairing.result import Repair


def motion_before(motion: WholeBodyMotion, repair: Repair) -> WholeBodyMotion:
    """The states of a motion in its repair's phases, in the plan's frame, from the plan's start on.

    Heights stay the file's own, so that feet that float or sink are seen to do so; forces are left
    out. Raises `ValueError` of a repair without phases.
    """
    if not repair.phases:
        raise ValueError("phases: expected those of the jump that was repaired, got none")
    start, end = repair.phases[0].start_s, repair.phases[-1].end_s
    half = 0.5 * float(np.diff(motion.time).min())
    there = (motion.time >= start - half) & (motion.time <= end + half)
    x, y, _ = repair.frame_origin
    frame = Frame(repair.frame_yaw, np.array([x, y, 0.0]))
    qpos, qvel = motion.qpos[there], motion.qvel[there]
    qpos[:, :3], qpos[:, 3:7] = frame.points(qpos[:, :3]), frame.attitudes(qpos[:, 3:7])
    qvel[:, :3] = Frame(frame.yaw, np.zeros(3)).points(qvel[:, :3])  # the base's own axes stay
    time = motion.time[there]
    return motion_of_states(motion.robot, motion.origin, time - time[0], qpos, qvel, motion.fps)
