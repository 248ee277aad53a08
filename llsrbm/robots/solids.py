"""The solids of a robot's links, in the frames of the joints that move them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import coal
import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.errors import RobotFileError
from llsrbm.mechanics import CORNERS
from llsrbm.robots.description import FARTHEST, Description, Solid
from llsrbm.robots.mesh_files import read_meshes
from llsrbm.robots.urdf import frame_id

if TYPE_CHECKING:
    import trimesh

_ROUND = 32  # faces around a cylinder that is drawn
_FLAT = 1e-5  # of its length, the thickness from which on a mesh has a hull


@dataclass(frozen=True, eq=False)
class PlacedSolid:
    """A solid of a link.

    Attributes:
        link: name in the URDF; joint: Pinocchio's index of the one that moves it.
        placement: of the solid's frame in that of the joint.
    """

    link: str
    joint: int
    placement: pin.SE3
    solid: Solid

    @property
    def is_sphere(self) -> bool:
        """Whether it is a ball."""
        return self.solid.kind == "sphere"

    @cached_property
    def vertices(self) -> Array:
        """(n, 3) m: of a mesh, each place once, as its faces come; in the solid's frame. Raises
        `RobotFileError`: the mesh cannot be read.
        """
        every = np.concatenate([mesh.vertices[mesh.faces.ravel()] for mesh in self._read()])
        first = np.unique(every, axis=0, return_index=True)[1]
        return every[np.sort(first)] * self.solid.size

    def hull_vertices(self) -> Array:
        """(n, 3) m: of a mesh that has a hull. Raises `RobotFileError`: it is flat, or cannot be
        read.
        """
        points = self.vertices
        along = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2]
        lengths = np.ptp(points @ along.T, axis=0)
        if len(points) < 4 or lengths.min() <= _FLAT * lengths.max():
            raise RobotFileError(
                f'{self.solid.file}: this mesh of link "{self.link}" is flat and has no hull; '
                "expected one that fills some space"
            )
        return points

    def _read(self) -> tuple[trimesh.Trimesh, ...]:
        """Its meshes as their file has them, in a size that a robot has."""
        meshes = read_meshes(self.solid.file)
        farthest = max(float(np.abs(mesh.vertices * self.solid.size).max()) for mesh in meshes)
        if farthest > FARTHEST:
            raise RobotFileError(
                f'{self.solid.file}: this mesh of link "{self.link}" has a corner {farthest:.3g} m '
                f"from its origin; expected m, up to {FARTHEST:g}, or "
                'scale="0.001 0.001 0.001" of a mesh in mm'
            )
        return meshes

    @property
    def half_lengths(self) -> Array:
        """(3,) m: of the smallest box around it along its own axes; not of a mesh."""
        size = self.solid.size
        match self.solid.kind:
            case "box":
                return np.array(size) / 2
            case "sphere":
                return np.full(3, size[0])
            case "capsule":
                return np.array([size[0], size[0], size[1] / 2 + size[0]])
        return np.array([size[0], size[0], size[1] / 2])

    @cached_property
    def corners(self) -> Array:
        """(n, 3) m: of a mesh its vertices, else the corners of the box around it; joint frame."""
        mesh = self.solid.kind == "mesh"
        own = self.vertices if mesh else (2 * CORNERS - 1) * self.half_lengths
        return own @ self.placement.rotation.T + self.placement.translation

    def meshes(self) -> Iterator[trimesh.Trimesh]:
        """Copies of its meshes in the joint's frame, with their own looks if they have some."""
        import trimesh

        size, (a, *rest) = np.array(self.solid.size), self.solid.size
        place, scale = self.placement.homogeneous, np.eye(4)
        match self.solid.kind:
            case "box":
                drawn = [trimesh.creation.box(extents=size)]
            case "sphere":
                drawn = [trimesh.creation.icosphere(subdivisions=3, radius=a)]
            case "cylinder":
                drawn = [trimesh.creation.cylinder(radius=a, height=rest[0], sections=_ROUND)]
            case "capsule":
                capsule = trimesh.creation.capsule(height=rest[0], radius=a, count=(10, _ROUND))
                capsule.apply_translation([0.0, 0.0, -capsule.bounds.mean(axis=0)[2]])
                drawn = [capsule]
            case "mesh":
                scale[:3, :3] = np.diag(size)
                drawn = [mesh.copy() for mesh in self._read()]
        for mesh in drawn:
            mesh.apply_transform(place @ scale)
            yield mesh


def placed_solids(
    robot: Description, model: pin.Model, kind: Literal["visuals", "collisions"]
) -> list[PlacedSolid]:
    """A URDF's solids of a kind, placed in the frames of the model's joints."""
    found = []
    for index, name in sorted((frame_id(model, link), link) for link in robot.links):
        frame = model.frames[index]
        for solid in getattr(robot.links[name], kind):
            placement = frame.placement * solid.origin.placement
            found.append(PlacedSolid(name, int(frame.parentJoint), placement, solid))
    return found


def coal_shape(solid: PlacedSolid) -> coal.ShapeBase:
    """The same by coal; of a mesh its convex hull."""
    if solid.solid.kind == "mesh":
        return convex_hull(solid.hull_vertices())
    a, *rest = solid.solid.size
    match solid.solid.kind:
        case "box":
            return coal.Box(*solid.solid.size)
        case "sphere":
            return coal.Sphere(a)
        case "cylinder":
            return coal.Cylinder(a, rest[0])
    return coal.Capsule(a, rest[0])


def convex_hull(points: Array) -> coal.ShapeBase:
    """The convex hull of points (n, 3)."""
    every = coal.StdVec_Vec3s()
    for point in points:
        every.append(point)
    return coal.Convex.convexHull(every, False, "")
