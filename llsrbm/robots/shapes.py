"""Convex shapes of a robot's links: boxes, spheres, cylinders, capsules, hulls of a few points.

They are the URDF's collision shapes; of a mesh its convex hull. A body without any (Go2's front
hips, SLIDER's legs) has its visual shapes, treated alike, and so has a sole of which the URDF knows
only the spheres that it stands on. Shins end two radii before the middle of their foot's ball.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

import coal
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from llsrbm.arrays import Array
from llsrbm.cache import cache_path, content_key, read_arrays, write_arrays
from llsrbm.mechanics import CORNERS
from llsrbm.robots.feet import collision_shapes, foot_contacts
from llsrbm.robots.robot import Leg, Robot
from llsrbm.robots.solids import PlacedSolid, convex_hull, placed_solids

Kind = Literal["sphere", "box", "cylinder", "capsule", "hull"]

_LOSS = 1e-3  # m of a mesh outside the hull that stands for it
SHORT = 2.0  # radii of a foot's ball by which shins end before its middle
_PLAIN = ("link", "joint", "kind", "size", "rotation", "centre")  # arrays of the cache, with others
_METHOD = "shapes 7"  # a new one makes cached shapes old


@dataclass(frozen=True, eq=False)
class Shape:
    """A convex shape of a link.

    Attributes:
        link: name in the URDF; joint: Pinocchio's index of the one that moves it.
        size: (3,) m: radius of a sphere; half lengths of a box; radius and half length along z of a
            cylinder, and of a capsule without its caps; filled up with zeros.
        rotation, centre: (3, 3), (3,) m: the shape's frame in that of the joint.
        points: (n, 3) m, of a hull in the shape's frame.
        foot: whether its link is one that stands on the ground, or is fixed to a sole.
    """

    link: str
    joint: int
    kind: Kind
    size: Array
    rotation: Array
    centre: Array
    points: Array
    foot: bool

    def geometry(self) -> coal.ShapeBase:
        """The shape by coal."""
        a, b, _ = (float(length) for length in self.size)
        match self.kind:
            case "sphere":
                return coal.Sphere(a)
            case "box":
                return coal.Box(*(2.0 * self.size))
            case "cylinder":
                return coal.Cylinder(a, 2.0 * b)
            case "capsule":
                return coal.Capsule(a, 2.0 * b)
            case "hull":
                return convex_hull(self.points)


@lru_cache(maxsize=16)
def link_shapes(robot: Robot) -> tuple[Shape, ...]:
    """All shapes of a robot's links, from the cache if its meshes were read before. Raises
    `RobotFileError`: the URDF's geometry cannot be read.
    """
    stamps = robot.urdf.mesh_stamps()
    if not stamps:
        return _shapes(robot)
    feet = repr((robot.file.foot, [leg.foot_frame for leg in robot.legs]))
    path = cache_path(
        f"shapes-{robot.name}", content_key(_METHOD, robot.urdf.content, feet, *stamps), ".npz"
    )
    stored = read_arrays(path)
    if stored is not None:
        return _decode(stored)
    shapes = _shapes(robot)
    write_arrays(path, _encode(shapes))
    return shapes


def _shapes(robot: Robot) -> tuple[Shape, ...]:
    objects = collision_shapes(robot)
    feet = [_foot_link(robot, leg, objects) for leg in robot.legs]
    bare = set(range(1, robot.model.njoints)) - {shape.joint for shape in objects}
    soles: set[int] = set()
    if not robot.file.foot.is_point:
        soles = {robot.model.frames[leg.foot_frame_id].parentJoint for leg in robot.legs}
    bare |= soles
    if bare:
        visual = placed_solids(robot.urdf, robot.model, "visuals")
        objects = [*objects, *(shape for shape in visual if shape.joint in bare)]
    balls = {} if not robot.file.foot.is_point else _balls(robot)
    shapes = [_shape(shape, foot=shape.link in feet or shape.joint in soles) for shape in objects]
    return tuple(
        shape
        if shape.foot or shape.joint not in balls
        else _up_to_the_foot(shape, *balls[shape.joint])
        for shape in shapes
    )


def _up_to_the_foot(shape: Shape, ball: Array, radius_of_ball: float) -> Shape:
    """The shape up to two radii from the middle of its foot's ball: the ground meets that alone.

    ANYmal's adapter reaches within 3 mm of the ball's end, Solo's shin within 1 mm, and a ball
    sinks in by as much as a robot lands.
    """
    short = SHORT * radius_of_ball
    if shape.kind in ("cylinder", "capsule"):
        radius, half, _ = shape.size
        along = shape.rotation.T @ (ball - shape.centre)
        height = float(along[2])
        reach = abs(height) - short
        if np.hypot(*along[:2]) > radius or abs(height) < half / 2 or reach > half:
            return shape
        shift = np.sign(height) * (reach - half) / 2
        size = np.array([radius, (half + reach) / 2, 0.0])
        return replace(shape, size=size, centre=shape.centre + shift * shape.rotation[:, 2])
    if shape.kind == "hull":
        end = shape.rotation.T @ (ball - shape.centre)
        outward = end - shape.points.mean(axis=0)
        outward /= np.linalg.norm(outward)
        beyond = np.maximum((shape.points - end) @ outward + short, 0.0)
        return replace(shape, points=shape.points - beyond[:, None] * outward)
    return shape


def _balls(robot: Robot) -> dict[int, tuple[Array, float]]:
    """Middles (3,) m of point feet in the frames of the joints that move them, and radii (m)."""
    frames = [robot.model.frames[leg.foot_frame_id] for leg in robot.legs]
    return {
        int(frame.parentJoint): (frame.placement.act(contact.centres[0]), contact.radius)
        for frame, contact in zip(frames, foot_contacts(robot), strict=True)
    }


def _foot_link(robot: Robot, leg: Leg, objects: list[PlacedSolid]) -> str:
    """The link with shapes that carries the frame of a foot."""
    frames = robot.model.frames
    solid = {shape.link for shape in objects}
    frame = leg.foot_frame_id
    joint = frames[frame].parentJoint
    while (
        frames[frame].name not in solid and frames[frames[frame].parentFrame].parentJoint == joint
    ):
        frame = frames[frame].parentFrame
    return str(frames[frame].name)


def _shape(given: PlacedSolid, *, foot: bool) -> Shape:
    solid, size, points = given.solid, np.zeros(3), np.empty((0, 3))
    if solid.kind == "mesh":
        points = _outermost(given)
    elif solid.kind == "box":
        size = np.array(solid.size) / 2
    else:
        size[: len(solid.size)] = solid.size
        size[1] /= 2
    return Shape(
        link=given.link,
        joint=given.joint,
        kind="hull" if solid.kind == "mesh" else solid.kind,
        size=size,
        rotation=np.array(given.placement.rotation),
        centre=np.array(given.placement.translation),
        points=points,
        foot=foot,
    )


def _outermost(mesh: PlacedSolid) -> Array:
    """Few of a mesh's points, whose hull leaves none of the others out by more than `_LOSS`."""
    points = mesh.hull_vertices()
    corners = points[ConvexHull(points, qhull_options="QJ").vertices]
    ends = np.concatenate([np.eye(3), -np.eye(3), 2 * CORNERS - 1])
    kept = np.unique((corners @ ends.T).argmax(axis=0))
    while True:
        faces = ConvexHull(corners[kept], qhull_options="QJ").equations
        outside = corners @ faces[:, :3].T + faces[:, 3]
        farthest = np.unique(outside.argmax(axis=0)[outside.max(axis=0) > _LOSS])
        more = np.union1d(kept, farthest)
        if len(more) == len(kept):
            return corners[kept]
        kept = more


def _encode(shapes: tuple[Shape, ...]) -> dict[str, NDArray[np.generic]]:
    return {
        **{
            name: np.array([getattr(shape, name) for shape in shapes]) for name in (*_PLAIN, "foot")
        },
        "points": np.concatenate([shape.points for shape in shapes]),
        "count": np.array([len(shape.points) for shape in shapes]),
    }


def _decode(stored: dict[str, NDArray[np.generic]]) -> tuple[Shape, ...]:
    points = np.split(stored["points"], np.cumsum(stored["count"])[:-1])
    rows = zip(*(stored[key] for key in _PLAIN), points, stored["foot"], strict=True)
    return tuple(
        Shape(str(link), int(joint), str(kind), size, rotation, centre, corners, bool(foot))  # type: ignore[arg-type]
        for link, joint, kind, size, rotation, centre, corners, foot in rows
    )
