"""Frames that are there more than once: a clip of a lower rate, written at a higher one.

Such a motion stands still and leaps in turn, so that neither feet nor falls are seen for what they
are. Without the repetitions it is what it was.
"""

from __future__ import annotations

import numpy as np

from llsrbm.motion.whole_body import WholeBodyMotion, motion_of_states, velocities

AT_REST = 0.1  # s: a robot whose frames are alike for longer stands still
ALIKE = 1e-9  # rad or m; tables have that many digits


def without_repeated(motion: WholeBodyMotion) -> WholeBodyMotion:
    """The motion without frames that repeat the one before; where it is at rest all stay.

    Its frames are then not evenly spaced, and its velocities are differences. A motion without such
    frames is the same object.
    """
    qpos, time = motion.qpos, motion.time
    new = np.concatenate([[True], (np.abs(np.diff(qpos, axis=0)) > ALIKE).any(axis=1)])
    starts = np.flatnonzero(new)
    ends = np.concatenate([starts[1:], [len(time)]]) - 1
    rests = time[ends] - time[starts] > AT_REST
    kept = new | np.repeat(rests, np.diff(np.concatenate([starts, [len(time)]])))
    if kept.all() or kept.sum() < 2:
        return motion
    time, qpos = time[kept], qpos[kept]
    return motion_of_states(motion.robot, motion.origin, time, qpos, velocities(time, qpos))
