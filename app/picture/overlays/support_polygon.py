"""The convex hull of the contact points that stand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from app.motion import colours
from app.motion.clip import Track
from app.motion.frames import Frames
from app.picture import gltf
from app.picture.drawing import Overlay
from app.picture.picture import Picture
from app.picture.turns import x_to

Array = NDArray[np.float64]

_WIDE, _THICK = 0.012, 0.003  # m, of an edge
_ABOVE = 0.004  # m; edges would flicker in the ground's own plane
_STRAIGHT = 1e-8  # m2: twice the area of three points that count as one line


class SupportPolygon(Overlay):
    """Its edges as bars: one a contact point, which leads to the next corner of the hull.

    A contact point that is no corner has a bar without a length; so the polygon may change its
    shape although nodes of a clip can only be moved, turned and stretched.
    """

    name = "support"
    title = "Support polygon"
    hint = "Convex hull of the contact points that stand: a robot at rest has its CoM above it."
    place = 110
    root = "/hull"

    def tracks(self, picture: Picture, frames: Frames) -> Sequence[Track]:
        count, legs, corners, _ = frames.contact_point.shape
        points = frames.contact_point.reshape(count, -1, 3) + np.array([0.0, 0.0, _ABOVE])
        standing = np.repeat(frames.contact, corners, axis=1)
        after = edges(points[..., :2], standing)
        there = after >= 0
        ends = np.take_along_axis(points, np.where(there, after, 0)[..., None], axis=1)
        along = np.where(there[..., None], ends - points, [1.0, 0.0, 0.0])
        length = np.linalg.norm(along, axis=2)
        size = there[..., None] * np.stack(
            [length + _WIDE, np.full_like(length, _WIDE), np.full_like(length, _THICK)], axis=2
        )
        return [
            Track(
                (name,),
                points[:, point] + along[:, point] / 2,
                x_to(along[:, point]),
                size[:, point],
            )
            for point, name in enumerate(self.nodes(gltf.bar(colours.SUPPORT), legs * corners))
        ]


def edges(points: Array, standing: NDArray[np.bool_]) -> NDArray[np.int64]:
    """The hull's edges, (F, C): of each of the points that stand the next corner, or -1.

    Against the clock, seen from above: `points` (F, C, 2) m, `standing` (F, C).
    """
    after = np.full(standing.shape, -1, dtype=np.int64)
    for frame, (places, counted) in enumerate(zip(points, standing, strict=True)):
        corners = _hull(places, np.flatnonzero(counted))
        if len(corners) > 1:
            after[frame, corners] = np.roll(corners, -1)
    return after


def _hull(points: Array, among: NDArray[np.int64]) -> list[int]:
    """Corners of the convex hull against the clock (Andrew's monotone chain)."""
    order = [int(i) for i in among[np.lexsort(points[among].T[::-1])]]
    places = points.tolist()

    def left_of(a: int, b: int, c: int) -> bool:
        (ax, ay), (bx, by), (cx, cy) = places[a], places[b], places[c]
        return bool((bx - ax) * (cy - ay) - (by - ay) * (cx - ax) > _STRAIGHT)

    def chain(path: list[int]) -> list[int]:
        corners: list[int] = []
        for point in path:
            while len(corners) > 1 and not left_of(corners[-2], corners[-1], point):
                corners.pop()
            corners.append(point)
        return corners

    if len(order) < 3:
        return order
    return chain(order)[:-1] + chain(order[::-1])[:-1]
