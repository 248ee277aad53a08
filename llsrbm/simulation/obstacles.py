"""The ground before and beyond an obstacle, and the obstacle, as boxes.

A hurdle stands on the ground. Beside a gap lie two blocks, the ground as far below them as the gap
is deep. All of it is there all the time. What touches a hurdle has not jumped over it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from llsrbm.request.obstacle import Obstacle
from llsrbm.simulation.block import Block

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Standing:
    """Contact points (c, 3) m of the feet that stand in one place, and its height, m."""

    points: Array
    height: float


def ground_and_blocks(
    obstacle: Obstacle, places: Sequence[Standing], margin: float
) -> tuple[float, list[Block]]:
    """The height of the ground, m, and what stands on it.

    Args:
        obstacle: across the world's x axis.
        places: where feet stand, the start first.
        margin: m that blocks reach beyond the feet, away from the obstacle.
    """
    points = np.concatenate([place.points for place in places])
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    middle = (obstacle.near + obstacle.far) / 2
    before, beyond = places[0].height, places[0].height
    for place in places:  # on either side they are at one height: the planner saw to it
        if (place.points[:, 0] > middle).any():
            beyond = place.height
    ground = min(before, beyond, obstacle.height) + 0.0  # no negative zero

    def box(name: str, start: float, end: float, top: float, *, untouched: bool = False) -> Block:
        return Block(
            name=name,
            centre=np.array([(start + end) / 2, (low[1] + high[1]) / 2, (ground + top) / 2]),
            size=np.array([end - start, high[1] - low[1], top - ground]),
            yaw=0.0,
            untouched=untouched,
        )

    blocks = []
    if before > ground:
        blocks.append(box("block", low[0], obstacle.near, before))
    if obstacle.height > ground:
        top = obstacle.height
        blocks.append(box("hurdle", obstacle.near, obstacle.far, top, untouched=True))
    if beyond > ground:
        blocks.append(box("box", obstacle.far, max(high[0], obstacle.far + margin), beyond))
    return ground, blocks
