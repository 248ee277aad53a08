"""How much room a robot takes: boxes around its bodies, and what two motions of it are apart."""

from functools import lru_cache

import numpy as np

from llsrbm.arrays import Array
from llsrbm.look.collision_visuals import visuals_at_once
from llsrbm.look.shown_motion import ShownMotion
from llsrbm.look.visuals import default_pose
from llsrbm.mechanics import CORNERS, rotation_matrices
from llsrbm.motion.block import Block
from llsrbm.request.jump import Jump
from llsrbm.request.route import waypoints
from llsrbm.robots import Robot

_LARGE = 1.5  # m, of a block that need not be in sight as a whole
_DIRECTIONS = 64  # in which the outermost points are looked for


@lru_cache(maxsize=8)
def extents(robot: Robot) -> tuple[tuple[int, ...], Array]:
    """Indices of the bodies that have a mesh, and the corners (8, 3) m of a box around each."""
    visuals = visuals_at_once(robot)  # collision shapes are as large, to some centimetres
    lows = [visual.vertices.min(axis=0) for visual in visuals]
    corners = [low + CORNERS * np.ptp(v.vertices, axis=0) for low, v in zip(lows, visuals)]
    return tuple(visual.joint_id - 1 for visual in visuals), np.reshape(corners, (-1, 8, 3))


def around(robot: Robot, position: Array, wxyz: Array) -> Array:
    """Corners (F, C, 8, 3) m of boxes around the bodies of a robot in all of its poses.

    Those are of all bodies, (F, B, 3) m and (F, B, 4). Without meshes their origins count.
    """
    bodies, corners = extents(robot)
    if not bodies:
        return np.repeat(position[:, :, None], 8, axis=2)
    turn = rotation_matrices(wxyz[:, bodies])
    return position[:, bodies, None] + np.einsum("fbij,bcj->fbci", turn, corners)


def around_default(robot: Robot) -> Array:
    """The same of a robot in its default posture, (1, C, 8, 3) m."""
    position, wxyz = default_pose(robot)
    return around(robot, position[None], wxyz[None])


def around_landings(robot: Robot, jump: Jump | None) -> Array:
    """Corners (N, 3) m of boxes around a robot that waits, and around it where a request lands."""
    here = around_default(robot).reshape(-1, 3)
    places = () if jump is None else waypoints(jump.landings)
    return np.concatenate([here, *(here + np.array(place[:3]) for place in places)])


def corners(block: Block, largest: float = _LARGE) -> Array:
    """Corners (8, 3) m of a block, as far as it is near: what is large is ground."""
    size = np.where(block.size < largest, block.size, 0.0)
    return block.centre + ((CORNERS - 0.5) * size) @ block.rotation.T


def outermost(points: Array) -> Array:
    """The farthest of points (..., 3) in `_DIRECTIONS` directions: about their convex hull."""
    flat = points.reshape(-1, 3)
    # On a spiral around the sphere, which spaces them evenly.
    k = np.arange(_DIRECTIONS)
    z, turn = 1 - (2 * k + 1) / _DIRECTIONS, k * np.pi * (3 - np.sqrt(5))
    radius = np.sqrt(1 - z * z)
    along = np.stack([radius * np.cos(turn), radius * np.sin(turn), z])
    return flat[np.unique(np.argmax(flat @ along, axis=0))]


def apart(robot: Robot, one: ShownMotion, other: ShownMotion, time: Array) -> Array:
    """Distance (F, B) m of every body in two motions at `time` (F,) s, of its farthest corner.

    Before and after a motion, its first and its last instant hold.
    """
    index = np.searchsorted(one.time, time).clip(0, len(one.time) - 1)
    bodies, _ = extents(robot)
    columns = list(bodies) or list(range(one.body_position.shape[1]))
    here = around(robot, one.body_position, one.body_wxyz)[index]
    there = around(robot, other.body_position, other.body_wxyz)
    after = np.searchsorted(other.time, time).clip(1, max(1, len(other.time) - 1))
    if len(other.time) > 1:
        step = other.time[after] - other.time[after - 1]
        share = ((time - other.time[after - 1]) / step).clip(0.0, 1.0)[:, None, None, None]
        there = there[after - 1] + share * (there[after] - there[after - 1])
    distance = np.zeros((len(time), one.body_position.shape[1]))
    distance[:, columns] = np.linalg.norm(here - there, axis=-1).max(axis=-1)
    return distance
