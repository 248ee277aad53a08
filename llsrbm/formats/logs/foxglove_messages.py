"""NumPy's numbers as the parts that Foxglove's messages are made of."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from foxglove import messages as fm

Array = NDArray[np.float64]


def nanoseconds(seconds: Array) -> list[int]:
    """Instants (K,) s as logs count them."""
    times: list[int] = np.round(seconds * 1e9).astype(np.int64).tolist()
    return times


def timestamp(time: int) -> fm.Timestamp:
    """An instant, ns."""
    from foxglove.messages import Timestamp

    return Timestamp(*divmod(time, 1_000_000_000))


def vector(xyz: Iterable[float]) -> fm.Vector3:
    """(3,) of anything."""
    from foxglove.messages import Vector3

    x, y, z = map(float, xyz)
    return Vector3(x=x, y=y, z=z)


def points(xyz: Array) -> list[fm.Point3]:
    """(V, 3) m."""
    from foxglove.messages import Point3

    return [Point3(x=x, y=y, z=z) for x, y, z in xyz.tolist()]


def quaternion(wxyz: Iterable[float]) -> fm.Quaternion:
    """(4,) w, x, y, z."""
    from foxglove.messages import Quaternion

    w, x, y, z = map(float, wxyz)
    return Quaternion(x=x, y=y, z=z, w=w)


def pose(xyz: Iterable[float], wxyz: Iterable[float]) -> fm.Pose:
    """A place (3,) m and an attitude (4,) w, x, y, z."""
    from foxglove.messages import Pose

    return Pose(position=vector(xyz), orientation=quaternion(wxyz))


def colour(rgb: Iterable[int], opacity: float = 1.0) -> fm.Color:
    """Of 0 to 255."""
    from foxglove.messages import Color

    r, g, b = (float(part) / 255 for part in rgb)
    return Color(r=r, g=g, b=b, a=opacity)


def colours(rgb: NDArray[np.uint8]) -> list[fm.Color]:
    """(V, 3) of 0 to 255; few of a mesh's differ."""
    distinct, which = np.unique(rgb, axis=0, return_inverse=True)
    palette = [colour(each) for each in distinct.tolist()]
    return [palette[i] for i in which.ravel().tolist()]


def turned_x_to(along: Array) -> Array:
    """Quaternions (..., 4) w, x, y, z that turn x to `along` (..., 3), as arrows want it.

    The short way; none where there is no length.
    """
    length = np.linalg.norm(along, axis=-1, keepdims=True)
    x = np.where(length > 0, along / np.where(length > 0, length, 1.0), [1.0, 0.0, 0.0])
    wxyz = np.stack([1 + x[..., 0], np.zeros(x.shape[:-1]), -x[..., 2], x[..., 1]], axis=-1)
    # Straight back, any half turn about an axis across.
    wxyz[x[..., 0] < -1 + 1e-9] = [0.0, 0.0, 0.0, 1.0]
    unit: Array = wxyz / np.linalg.norm(wxyz, axis=-1, keepdims=True)
    return unit
