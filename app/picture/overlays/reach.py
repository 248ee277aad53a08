"""Where the planner lets feet be."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from app.motion import colours
from app.motion.clip import Track
from app.picture import gltf
from app.picture.drawing import Group, Overlay
from app.picture.picture import Picture
from llsrbm.arrays import Array, BoolArray, IntArray
from llsrbm.look.shown_motion import ShownMotion
from llsrbm.planning.problem.placement import place_task
from llsrbm.robots import Robot

Region = tuple[tuple[float, float], tuple[float, float, float], tuple[float, float, float]]
"""Shortest and longest distance from the hip; lower and upper corner of a box about it, m."""

_GRID = 8  # squares along each side of a box' face
_SEARCH = 9  # places along each axis at which the middle of a region is looked for


class FeetReach(Overlay):
    """Regions that move with the base: of feet in flight, and of standing feet."""

    name = "reach"
    group = Group.FOOTHOLDS
    title = "Foot workspace"
    hint = "Region in which the plan keeps each foot: a box, within two distances from its hip."
    place = 140
    tints = (colours.REACH,)
    root = "/regions"

    def tracks(self, picture: Picture, frames: ShownMotion) -> Sequence[Track]:
        robot, planned, _ = picture.motion
        task = place_task(planned.plan.jump, robot, planned.plan.tuning)
        distance, lower, upper = task.reach.distance, task.reach.lower, task.reach.upper
        # Rounded so that a drag, which changes no limits, finds the meshes of before.
        top = round(min(upper[2], -task.lowest_hips), 6)
        flying = regions(robot, (distance, lower, upper))
        standing = regions(robot, (distance, lower, (*upper[:2], top)))
        base = frames.body_position[:, 0], frames.body_wxyz[:, 0]
        return [
            Track((name,), *base, np.repeat(there[:, foot, None], 3, axis=1).astype(float))
            for names, there in (
                (self.each("flying", flying), ~frames.stands),
                (self.each("standing", standing), frames.stands),
            )
            for foot, name in enumerate(names)
        ]


@lru_cache(maxsize=16)
def regions(robot: Robot, region: Region) -> tuple[bytes, ...]:
    """The region of each leg in the base frame, as a mesh."""
    import trimesh

    vertices, faces = surface(region)
    meshes = [
        trimesh.Trimesh(
            hip + mirror * vertices,
            faces if mirror.prod() > 0 else faces[:, ::-1],
            process=False,
        )
        for hip, mirror in zip(robot.hips, robot.mirrors, strict=True)
    ]
    return tuple(gltf.solid(mesh, colours.REACH, 0.16, sharp=False) for mesh in meshes)


def surface(region: Region) -> tuple[Array, IntArray]:
    """Vertices (V, 3) m in the hip's frame and faces of the boundary of a region.

    A grid on the box' faces, drawn in towards the region's middle: to the farther sphere where the
    box reaches out of it, and to the nearer one where it covers the box. No vertices and no faces
    of a region that is empty.
    """
    (near, far), lower, upper = region
    middle = _middle(region)
    if middle is None:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    points, faces = _box_grid(np.array(lower), np.array(upper))
    ray = points - middle
    # |middle + t ray| = radius, a quadratic equation in t.
    a, b = np.sum(ray * ray, axis=1), ray @ middle

    def hits(radius: float) -> tuple[Array, Array, BoolArray]:
        root = b * b - a * (middle @ middle - radius**2)
        crossing = root >= 0
        apart = np.sqrt(np.where(crossing, root, 0.0))
        return (-b - apart) / a, (-b + apart) / a, crossing

    share = np.minimum(1.0, hits(far)[1])
    enters, _, crosses = hits(near)
    share = np.where(crosses & (enters > 0) & (enters < share), enters, share)
    return middle + share[:, None] * ray, faces


def _middle(region: Region) -> Array | None:
    """A point well inside, from which the boundary is seen; None: nothing is inside."""
    (near, far), lower, upper = region
    sides = [np.linspace(lo, hi, _SEARCH) for lo, hi in zip(lower, upper, strict=True)]
    points = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 3)
    distance = np.linalg.norm(points, axis=1)
    room = np.minimum.reduce(
        [
            *(points - np.array(lower)).T,
            *(np.array(upper) - points).T,
            distance - near,
            far - distance,
        ]
    )
    best = int(room.argmax())
    return points[best] if room[best] > 0 else None


def _box_grid(lower: Array, upper: Array) -> tuple[Array, IntArray]:
    """A box' surface in squares of two triangles each, seen from outside."""
    steps = np.linspace(0.0, 1.0, _GRID + 1)
    u, v = (side.ravel() for side in np.meshgrid(steps, steps, indexing="ij"))
    corner = np.arange(_GRID * (_GRID + 1)).reshape(_GRID, _GRID + 1)[:, :-1].ravel()
    square = np.stack([corner, corner + _GRID + 1, corner + _GRID + 2, corner + 1], axis=1)
    triangles = np.concatenate([square[:, [0, 1, 2]], square[:, [0, 2, 3]]])
    points: list[Array] = []
    faces: list[IntArray] = []
    for axis in range(3):
        for end in (0.0, 1.0):
            share = np.empty((len(u), 3))
            share[:, axis], share[:, (axis + 1) % 3], share[:, (axis + 2) % 3] = end, u, v
            faces.append((triangles if end else triangles[:, ::-1]) + len(u) * len(points))
            points.append(lower + share * (upper - lower))
    return np.concatenate(points), np.concatenate(faces)
