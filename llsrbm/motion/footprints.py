"""Rectangles under feet, seen from above: around some, beside others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from llsrbm.arrays import Array

ROOM = 0.01  # m at least between an edge's two sides: feet that stand on it and feet beside it
MARGIN = 0.25  # m of landing box or start block around the feet: a robot may miss by that much


@dataclass(frozen=True, eq=False)
class Rectangle:
    """Seen from above, axes along a heading: corners `low` and `high`, (2,) m."""

    low: Array
    high: Array


def common(one: Rectangle, other: Rectangle) -> Rectangle:
    """The part that two have in common."""
    return Rectangle(np.maximum(one.low, other.low), np.minimum(one.high, other.high))


def around(points: Array, margin: float) -> Rectangle:
    """A rectangle around points (n, 2), so many m wider on each side."""
    return Rectangle(points.min(axis=0) - margin, points.max(axis=0) + margin)


def avoiding(points: Array, feet: Array, radius: float, share: float) -> Rectangle | None:
    """A rectangle around `points` (C, 2), as wide as `MARGIN`, beside the `feet` (L, c, 2) of
    another place.

    Each foot keeps to its side of the edge that it is planned to cross: of the four that with the
    widest gap. None if there is no room for the robot that stands on the other feet.
    """
    low, high = points.min(axis=0) - radius, points.max(axis=0) + radius
    others, apart = feet.reshape(-1, 2), radius + ROOM
    if meet(others, low - apart, high + apart):
        return None
    found = around(points, MARGIN)
    for foot in feet:
        gaps = np.array([low - foot.max(axis=0), foot.min(axis=0) - high]) - radius
        if gaps.max() < 0:
            return None
        beyond, axis = np.unravel_index(gaps.argmax(), gaps.shape)
        room = (1 - share) * gaps[beyond, axis]
        if beyond:
            found.high[axis] = min(found.high[axis], high[axis] + room)
        else:
            found.low[axis] = max(found.low[axis], low[axis] - room)
    return None if meet(others, found.low - radius, found.high + radius) else found


def meet(points: Array, low: Array, high: Array) -> bool:
    """Whether the convex hull of points (C, 2), which a robot stands over, meets a rectangle.

    Unless an axis separates them: one of the rectangle's, or across a line between two points.
    """
    corners = np.array([[x, y] for x in (low[0], high[0]) for y in (low[1], high[1])])
    lines = (points[:, None] - points)[~np.eye(len(points), dtype=bool)]
    across = np.concatenate([[[1, 0], [-1, 0], [0, 1], [0, -1]], lines[:, ::-1] * [1, -1]])
    across = across[across.any(axis=1)]  # two points may be one
    gaps = (across @ points.T).min(axis=1) - (across @ corners.T).max(axis=1)
    return bool((gaps < 0).all())
