"""Pickles that any NumPy can open, and that hold nothing but numbers, text, lists and arrays."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np

_PROTOCOL = 4  # Python 3.4 and later: simulators are tied to old ones


def write_pickle(path: Path, content: dict[str, Any]) -> None:
    """Write a dictionary."""
    with path.open("wb") as file:
        _Pickler(file, protocol=_PROTOCOL).dump(content)


class _Pickler(pickle.Pickler):
    """Arrays as `numpy.array(list)`: NumPy 2 names internals that NumPy 1 does not have."""

    def reducer_override(self, obj: Any) -> Any:
        if isinstance(obj, np.ndarray):
            return np.array, (obj.tolist(),)
        return NotImplemented
