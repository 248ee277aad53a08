"""The least of many distances over a motion, few of which are measured.

Of what was measured at one instant no more is lost at another than both have moved since.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from llsrbm.arrays import Array


def least_distance(
    bounds: Array,
    measure: Callable[[int, int], float],
    moved: Callable[[int, int], Array],
) -> tuple[float, int, int]:
    """The least distance, m, its instant of T, and its pair of K; infinite where all bounds are.

    Args:
        bounds: (T, K) m: no more than each distance.
        measure: the distance of a pair at an instant, m.
        moved: (T,) m: by how much a pair can have come nearer until each instant, from one of them.
    """
    bounds = bounds.copy()
    least, at = np.inf, (0, 0)
    while bounds.size:
        t, k = divmod(int(bounds.argmin()), bounds.shape[1])
        if not bounds[t, k] < least:
            break
        distance = measure(t, k)
        np.maximum(bounds[:, k], distance - moved(t, k), out=bounds[:, k])
        bounds[t, k] = np.inf
        if distance < least:
            least, at = distance, (t, k)
    return least, *at
