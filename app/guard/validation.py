"""Values of controls, checked where they are read: a browser's script can send anything."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from llsrbm.number_text import short


def option(
    label: str, value: Any, valid: Sequence[str], otherwise: str, complaints: list[str]
) -> str:
    """`value` if it is one of `valid`, or else `otherwise` and a complaint."""
    if isinstance(value, str) and value in valid:
        return value
    complaints.append(f"{label}: expected one of {', '.join(valid)}, got {value!r:.80}")
    return otherwise


def number(label: str, value: Any, ends: tuple[float, float], complaints: list[str]) -> float:
    """`value` if it is a number between `ends`, or else the nearest one and a complaint."""
    lowest, highest = ends
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        complaints.append(f"{label}: expected a number, got {value!r:.80}")
        return min(max(0.0, lowest), highest)
    slack = 1e-6 * max(1.0, abs(value))  # a browser rounds
    if not lowest - slack <= value <= highest + slack:
        complaints.append(
            f"{label}: expected {short(lowest, 4)} to {short(highest, 4)}, got {short(value)}; "
            "the nearest is taken"
        )
    return min(max(float(value), lowest), highest)


def numbers(values: object, count: int) -> tuple[float, ...] | None:
    """So many finite numbers, or None: a script may send anything for a pose."""
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        return None
    if array.shape != (count,) or not np.isfinite(array).all():
        return None
    return tuple(float(value) for value in array)


def put(handle: Any, value: float | str | bool) -> None:
    """Set a control; mypy does not see the setter of viser's property."""
    handle.value = value
