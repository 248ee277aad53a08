"""Faces of a body that nobody sees: drives behind covers, threads of screws, backs of plates.

Simplified, what lies close behind a cover comes through it, and takes faces from what is seen.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from llsrbm.arrays import Array

if TYPE_CHECKING:
    import trimesh

_RAYS = 2, 8, 32  # from each side of a point; the next number where none of these came out
_LARGE = 0.01  # m: edges of triangles that are looked at from more than their middles
_TO_CORNERS = 0.8  # of the way from a middle to each corner
_SEED = 1  # of a process that has drawn no number yet


def without_hidden(parts: Sequence[trimesh.Trimesh]) -> list[trimesh.Trimesh]:
    """Parts of one body without the faces from which no ray leaves it; none that are all hidden.

    Rays are drawn at random, by the C library: from the same seed each time where it can be set,
    else faces that are seen through a slit may stay or go.
    """
    if os.name == "posix":
        ctypes.CDLL(None).srand(_SEED)
    corners = np.concatenate([np.asarray(part.triangles) for part in parts])
    seen = np.split(_seen(corners), np.cumsum([len(part.faces) for part in parts])[:-1])
    if not any(kept.any() for kept in seen):  # of triangles without an area
        return list(parts)
    return [_of_faces(part, kept) for part, kept in zip(parts, seen, strict=True) if kept.any()]


def _of_faces(part: trimesh.Trimesh, kept: NDArray[np.bool_]) -> trimesh.Trimesh:
    found = part.copy()
    found.update_faces(kept)
    found.remove_unreferenced_vertices()
    return found


def _seen(corners: Array) -> NDArray[np.bool_]:
    """(F,) whether a ray leaves the body from a face, of (F, 3, 3) m."""
    from igl.embree import EmbreeIntersector, ambient_occlusion

    body = EmbreeIntersector()
    body.init(corners.reshape(-1, 3), np.arange(corners.size // 3, dtype=np.int64).reshape(-1, 3))
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    point, face = _points(corners)
    seen = np.zeros(len(corners), dtype=bool)
    for rays in _RAYS:
        for side in normal, -normal:
            seen[face[ambient_occlusion(body, point, side[face], rays) < 1.0]] = True
            left = ~seen[face]
            point, face = point[left], face[left]
    return seen


def _points(corners: Array) -> tuple[Array, NDArray[np.int64]]:
    """(P, 3) m where faces are looked at from, and (P,) the face of each."""
    middle, every = corners.mean(axis=1), np.arange(len(corners))
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    large = np.flatnonzero(edges.max(axis=1) > _LARGE)
    near = (1 - _TO_CORNERS) * middle[large, None] + _TO_CORNERS * corners[large]
    return np.concatenate([middle, near.reshape(-1, 3)]), np.concatenate([every, large.repeat(3)])
