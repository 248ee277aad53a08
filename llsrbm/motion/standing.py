"""Which feet stand, told from their motion alone, where nothing else tells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_STILL = 0.15  # m/s: a foot that is slower ...
_LONG = 0.1  # s: ... for that long stands; at the top of a flight it is so for a third of that
_LEVEL = 0.005  # m from the height at which the foot stands before or after
_SLIPS = 0.3  # m/s: the fastest that a foot that low may be; it wobbles and slips as it lands


def standing(time: Array, speed: Array, height: Array) -> NDArray[np.bool_]:
    """Tell feet that stand from feet in the air: (K, L).

    A foot that hardly moves for a tenth of a second stands, wherever: on the ground or on a box.
    That gives the heights at which it stands. It also stands at instants at which it is as high as
    at the nearest of those times and not fast.

    Args:
        time: (K,) s.
        speed: (K, L) m/s of the feet's contact points.
        height: (K, L) m of them.
    """
    stands = np.zeros(speed.shape, dtype=np.bool_)
    for foot in range(speed.shape[1]):
        level = np.full(len(time), np.inf)
        away = np.full(len(time), np.inf)
        for first, last in _runs(speed[:, foot] < _STILL):
            if time[last] - time[first] < _LONG:
                continue
            until = np.maximum(np.maximum(time[first] - time, time - time[last]), 0.0)
            nearest = until < away
            away[nearest] = until[nearest]
            level[nearest] = np.median(height[first : last + 1, foot])
        low = np.abs(height[:, foot] - level) < _LEVEL
        stands[:, foot] = low & (speed[:, foot] < _SLIPS)
    return stands


def _runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last index of each stretch of true ones."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return [(int(first), int(end) - 1) for first, end in edges.reshape(-1, 2)]
