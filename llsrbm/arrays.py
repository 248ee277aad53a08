"""Types of NumPy arrays, by what they hold, and stretches of flags; docstrings say the shapes."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


def stretches(on: BoolArray) -> list[tuple[int, int]]:
    """[start, end) of each stretch of True in (T,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]]).astype(np.int8)))
    return [(int(start), int(end)) for start, end in edges.reshape(-1, 2)]
