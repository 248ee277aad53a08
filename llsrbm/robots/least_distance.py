"""The least of many distances over a motion, few of which are measured.

A pair that is d apart at one instant is d less the way since, or more, apart at another: all
instants are passed by in between at which it cannot be nearer than what was found.
"""

from bisect import bisect_left
from collections.abc import Callable

import numpy as np

from llsrbm.arrays import Array

LOOKED = 16  # instants at which all pairs are measured first, evenly spread


def least_distance(
    bounds: Array,
    measure: Callable[[int, int], float],
    way: Callable[[int], Array],
    known: float = np.inf,
) -> tuple[float, int, int]:
    """The least distance, m, its instant of T, and its pair of K; infinite where all bounds are.

    Args:
        bounds: (T, K) m: no more than each distance.
        measure: the distance of a pair at an instant, m.
        way: (T,) m, growing: how far a pair has moved against each other since the first instant,
            no less.
        known: m, that of another motion: where this one has none that is less it is `known`.
    """
    least, at = known, (0, 0)

    def looked(t: int, k: int) -> float:
        nonlocal least, at
        distance = measure(t, k)
        if distance < least:
            least, at = distance, (t, k)
        return distance

    for t in range(0, len(bounds), max(len(bounds) // LOOKED, 1)):
        for k in np.argsort(bounds[t]).tolist():
            if not bounds[t, k] < least:
                break
            looked(t, k)
    for k in np.argsort(bounds.min(axis=0, initial=np.inf)).tolist():
        instants = np.flatnonzero(bounds[:, k] < least)
        gone = way(k)[instants].tolist() if len(instants) else []
        i = 0
        while i < len(gone):
            distance = looked(int(instants[i]), k)
            i = bisect_left(gone, gone[i] + distance - least, i + 1)
    return least, *at


def way_of(rotation: Array, centre: Array, radius: float) -> Array:
    """(T,) m that points of a ball have moved at most since the first instant.

    `rotation`: (T, 3, 3); `centre`: (T, 3) m of the ball, in the same frame; `radius`: m.
    """
    went = np.linalg.norm(np.diff(centre, axis=0), axis=1)
    # A turn by an angle a moves a point at most by 2 sin(a / 2) of its distance.
    turned = np.linalg.norm(np.diff(rotation, axis=0), axis=(1, 2)) / np.sqrt(2)
    return np.concatenate([[0.0], np.cumsum(went + radius * turned)])
