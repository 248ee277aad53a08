"""Axes of the links, and the shapes with which the simulation lets the robot touch the world."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING

import coal
import numpy as np

from app.motion import colours
from app.motion.clip import Track
from app.motion.frames import Frames
from app.picture import gltf
from app.picture.drawing import Overlay
from app.picture.picture import Picture
from llsrbm.robots import Robot
from llsrbm.robots.feet import collision_shapes, foot_contacts
from llsrbm.robots.urdf import BASE_JOINT

if TYPE_CHECKING:
    import trimesh

_LENGTH = 0.1  # m, of an axis


class LinkFrames(Overlay):
    """Three short bars at the joint that moves a link; the base's at its origin."""

    name = "frames"
    title = "Link frames"
    hint = "Axes of the links, x red, y green, z blue, where the joints are that move them."
    place = 150
    root = "/axes"

    def tracks(self, picture: Picture, frames: Frames) -> Sequence[Track]:
        size = np.full((len(frames.time), 3), _LENGTH)
        return [
            Track((name,), frames.body_position[:, body], frames.body_wxyz[:, body], size)
            for body, name in enumerate(self.nodes(gltf.triad(), frames.body_position.shape[1]))
        ]


_OPACITY = 0.45


class CollisionShapes(Overlay):
    """The trunk's boxes, cylinders, spheres and convex hulls, and the feet's spheres.

    As `llsrbm.simulation.scene` builds them; legs pass through the ground there, too.
    """

    name = "collision"
    title = "Collision shapes"
    hint = "The shapes that touch the ground in a simulation: the trunk's and the feet's."
    place = 160
    root = "/hulls"

    def tracks(self, picture: Picture, frames: Frames) -> Sequence[Track]:
        robot, _, _ = picture.motion
        bodies, meshes = zip(*_meshes(robot), strict=True)
        return [
            Track((node,), frames.body_position[:, body], frames.body_wxyz[:, body])
            for body, node in zip(bodies, self.each("", meshes), strict=True)
        ]


@lru_cache(maxsize=8)
def _meshes(robot: Robot) -> tuple[tuple[int, bytes], ...]:
    return tuple(
        (body, gltf.solid(mesh, colours.COLLISION, _OPACITY)) for body, mesh in shapes_of(robot)
    )


def shapes_of(robot: Robot) -> list[tuple[int, trimesh.Trimesh]]:
    """Index of a body and its shapes in the frame of its joint: the base's, then each foot's."""
    import trimesh

    trunk = []
    for shape in collision_shapes(robot):
        mesh = _mesh(shape.geometry) if shape.parentJoint == BASE_JOINT else None
        if mesh is not None:
            mesh.apply_transform(shape.placement.homogeneous)
            trunk.append(mesh)
    found = [(BASE_JOINT - 1, trimesh.util.concatenate(trunk))] if trunk else []
    for leg, contact in zip(robot.legs, foot_contacts(robot), strict=True):
        frame = robot.model.frames[leg.foot_frame_id]
        spheres = []
        for centre in contact.centres:
            sphere = trimesh.creation.icosphere(subdivisions=2, radius=contact.radius)
            sphere.apply_translation(frame.placement.act(centre))
            spheres.append(sphere)
        found.append((leg.joint_ids[-1] - 1, trimesh.util.concatenate(spheres)))
    return found


def _mesh(geometry: coal.CollisionGeometry) -> trimesh.Trimesh | None:
    """A shape that the simulation has, too; None: of another kind."""
    import trimesh

    if isinstance(geometry, coal.Sphere):
        return trimesh.creation.icosphere(subdivisions=2, radius=geometry.radius)
    if isinstance(geometry, coal.Box):
        return trimesh.creation.box(extents=2 * np.asarray(geometry.halfSide))
    if isinstance(geometry, coal.Cylinder):
        return trimesh.creation.cylinder(geometry.radius, 2 * geometry.halfLength, sections=24)
    if isinstance(geometry, coal.BVHModelBase):
        return trimesh.convex.convex_hull(np.asarray(geometry.vertices()))
    return None
