"""What was planned anew while a robot was under way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DEADLINE = 0.02
"""s of computing time within which an answer is in time: 50 Hz."""


@dataclass(frozen=True, eq=False)
class Replan:
    """One answer of the replanner: K knots, L legs; world frame.

    Attributes:
        asked: s since the first plan's start, when the state was measured.
        applied: s, when the controller took it over; nan: it came too late, or not at all.
        computing_time: s of the processor's time.
        solved: whether a motion was found that satisfies every constraint.
        iterations: of the solver.
        touchdown: s, when the first feet are to meet the ground.
        time: (K,) s since the first plan's start.
        com: (K, 3) m; base_quat: (K, 4) w, x, y, z.
        foot_position: (K, L, 3) m; foot_quat: (K, L, 4) w, x, y, z.

    Arrays have no knots where nothing was found.
    """

    asked: float
    applied: float
    computing_time: float
    solved: bool
    iterations: int
    touchdown: float
    time: Array
    com: Array
    base_quat: Array
    foot_position: Array
    foot_quat: Array


def followed(replans: Sequence[Replan], time: float) -> Replan | None:
    """The newest one that is followed at a time, s; None: still the first plan."""
    taken = [replan for replan in replans if replan.applied <= time]  # nan is never
    return max(taken, key=lambda replan: replan.applied, default=None)
