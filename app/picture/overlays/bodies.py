"""Axes of the links, and the shapes with which the simulation lets the robot touch the world."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from app.motion import colours
from app.motion.clip import Track
from app.picture import gltf
from app.picture.drawing import Group, Overlay
from app.picture.picture import Picture
from llsrbm.look.shown_motion import ShownMotion
from llsrbm.robots import Robot
from llsrbm.robots.feet import foot_contacts
from llsrbm.robots.shapes import Shape, link_shapes

if TYPE_CHECKING:
    import trimesh

_LENGTH = 0.1  # m, of an axis


class LinkFrames(Overlay):
    """Three short bars at the joint that moves a link; the base's at its origin."""

    name = "frames"
    group = Group.DEBUG
    title = "Link frames"
    hint = "Axes of the links, x red, y green, z blue, where the joints are that move them."
    place = 150
    tints = gltf.AXES
    root = "/axes"

    def tracks(self, picture: Picture, frames: ShownMotion) -> Sequence[Track]:
        size = np.full((len(frames.time), 3), _LENGTH)
        return [
            Track((name,), frames.body_position[:, body], frames.body_wxyz[:, body], size)
            for body, name in enumerate(self.nodes(gltf.triad(), frames.body_position.shape[1]))
        ]


_OPACITY = 0.45


class CollisionShapes(Overlay):
    """Boxes, cylinders, spheres and hulls of the links, and the feet's spheres.

    As `llsrbm.simulation.scene` builds them.
    """

    name = "collision"
    group = Group.DEBUG
    title = "Collision shapes"
    hint = "The shapes that touch the ground, boxes and each other in a simulation."
    place = 160
    tints = (colours.COLLISION,)
    root = "/hulls"

    def tracks(self, picture: Picture, frames: ShownMotion) -> Sequence[Track]:
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
    """Index of a body and its shapes, the links' and the feet's, in the frame of its joint."""
    import trimesh

    parts: dict[int, list[trimesh.Trimesh]] = defaultdict(list)
    for shape in link_shapes(robot):
        if shape.foot and shape.kind == "sphere":
            continue  # a foot's ball, see below
        parts[shape.joint - 1].append(_mesh(shape))
    for leg, contact in zip(robot.legs, foot_contacts(robot), strict=True):
        frame = robot.model.frames[leg.foot_frame_id]
        for centre in contact.centres:
            sphere = trimesh.creation.icosphere(subdivisions=2, radius=contact.radius)
            sphere.apply_translation(frame.placement.act(centre))
            parts[leg.joint_ids[-1] - 1].append(sphere)
    return [(body, trimesh.util.concatenate(meshes)) for body, meshes in sorted(parts.items())]


def _mesh(shape: Shape) -> trimesh.Trimesh:
    import trimesh

    radius, half, _ = shape.size
    match shape.kind:
        case "sphere":
            mesh = trimesh.creation.icosphere(subdivisions=2, radius=radius)
        case "box":
            mesh = trimesh.creation.box(extents=2 * shape.size)
        case "cylinder":
            mesh = trimesh.creation.cylinder(radius, 2 * half, sections=24)
        case "capsule":
            mesh = trimesh.creation.capsule(2 * half, radius, count=(10, 24))
        case "hull":
            mesh = trimesh.convex.convex_hull(shape.points)
    placement = np.eye(4)
    placement[:3, :3], placement[:3, 3] = shape.rotation, shape.centre
    mesh.apply_transform(placement)
    return mesh
