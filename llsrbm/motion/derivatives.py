"""Velocities of states of which a file holds positions only."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]


def velocities(time: Array, qpos: Array) -> Array:
    """(K, 6 + J) of states (K, 7 + J), both in MuJoCo's convention, K of 2 or more.

    Differences over the two intervals around an instant, exact for constant accelerations however
    long the intervals are. What changes at once, at an impact, is smeared over these two.

    Args:
        time: (K,) s, increasing.
        qpos: position, unit quaternion w, x, y, z of either sign, joints.
    """
    dt = np.diff(time)[:, None]
    attitude = Rotation.from_quat(qpos[:, 3:7], scalar_first=True)
    turned = (attitude[:-1].inv() * attitude[1:]).as_rotvec()  # in the base's axes
    moved = np.diff(np.delete(qpos, np.s_[3:7], axis=1), axis=0)
    rate = np.hstack([moved[:, :3], turned, moved[:, 3:]]) / dt  # of the intervals' middles
    if len(rate) == 1:
        return np.repeat(rate, 2, axis=0)
    inside = (dt[1:] * rate[:-1] + dt[:-1] * rate[1:]) / (dt[1:] + dt[:-1])
    # To either end on the straight line through the middle of its interval.
    return np.vstack([2 * rate[0] - inside[0], inside, 2 * rate[-1] - inside[-1]])
