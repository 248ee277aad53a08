"""A robot drawn by its collision shapes: there at once, while its meshes are being prepared."""

from __future__ import annotations

from collections import defaultdict
from functools import lru_cache
from typing import TYPE_CHECKING

import coal
import numpy as np
from numpy.typing import NDArray

from llsrbm.look.visuals import LinkVisual, link_visual, link_visuals, needs_preparation
from llsrbm.robots.feet import collision_shapes
from llsrbm.robots.robot import Robot

if TYPE_CHECKING:
    import pinocchio as pin
    import trimesh

_GREY = (148, 156, 166)  # of all bodies: it is a stand-in, and shows it
_ROUND = 20  # faces around a cylinder
_MANY_FACES = 2000  # of a mesh; G1's arms and head have 70,000
_HULL_FACES = 400
_CREASE = np.radians(40.0)  # edges sharper than this stay sharp under smooth shading


def visuals_at_once(robot: Robot) -> tuple[LinkVisual, ...]:
    """Something to draw the robot by, within some tenths of a second.

    Its light meshes if they were prepared before, or need no preparation because the URDF's visuals
    are boxes and the like; otherwise its collision shapes. Raises `RobotFileError`.
    """
    if needs_preparation(robot):
        return collision_visuals(robot)
    return link_visuals(robot, coarse=True)


@lru_cache(maxsize=8)
def collision_visuals(robot: Robot) -> tuple[LinkVisual, ...]:
    """The URDF's collision shapes, one grey mesh a moving body that has any; `RobotFileError`."""
    shapes: dict[int, list[trimesh.Trimesh]] = defaultdict(list)
    for shape in collision_shapes(robot):
        mesh = _mesh(shape)
        if mesh is not None:
            shapes[shape.parentJoint].append(mesh)
    return tuple(
        link_visual(robot.model, joint, pieces) for joint, pieces in sorted(shapes.items())
    )


def _mesh(shape: pin.GeometryObject) -> trimesh.Trimesh | None:
    import trimesh

    geometry = shape.geometry
    match geometry:
        case coal.Sphere():
            mesh = trimesh.creation.icosphere(subdivisions=2, radius=geometry.radius)
        case coal.Box():
            mesh = trimesh.creation.box(extents=2.0 * np.asarray(geometry.halfSide))
        case coal.Cylinder():
            mesh = trimesh.creation.cylinder(
                radius=geometry.radius, height=2.0 * geometry.halfLength, sections=_ROUND
            )
        case coal.BVHModelBase():
            mesh = _mesh_or_hull(geometry)
        case _:
            return None
    mesh = trimesh.graph.smooth_shade(mesh, angle=_CREASE, facet_minarea=None)
    normals = np.asarray(mesh.vertex_normals)
    grey = np.tile(np.array(_GREY, dtype=np.uint8), (len(mesh.vertices), 1))
    moved = trimesh.Trimesh(
        mesh.vertices, mesh.faces, vertex_normals=normals, vertex_colors=grey, process=False
    )
    moved.apply_transform(shape.placement.homogeneous)
    return moved


def _mesh_or_hull(geometry: coal.BVHModelBase) -> trimesh.Trimesh:
    """A mesh; of one with many faces its convex hull, as which the trunk is simulated, too."""
    import trimesh

    vertices = np.asarray(geometry.vertices())
    if geometry.num_tris > _MANY_FACES:
        hull = trimesh.convex.convex_hull(vertices)
        few = len(hull.faces) <= _HULL_FACES
        return hull if few else hull.simplify_quadric_decimation(face_count=_HULL_FACES)
    return trimesh.Trimesh(vertices, _triangles(geometry))


def _triangles(geometry: coal.BVHModelBase) -> NDArray[np.int64]:
    triangles = (geometry.tri_indices(i) for i in range(geometry.num_tris))
    return np.array([[triangle[k] for k in range(3)] for triangle in triangles], dtype=np.int64)
