"""A robot drawn by its collision shapes: there at once, while its meshes are being prepared."""

from __future__ import annotations

from collections import defaultdict
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from llsrbm.look.visuals import GREY, LinkVisual, link_visual, link_visuals, needs_preparation
from llsrbm.robots.feet import collision_shapes
from llsrbm.robots.robot import Robot
from llsrbm.robots.solids import PlacedSolid

if TYPE_CHECKING:
    import trimesh

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
        shapes[shape.joint] += [_grey(mesh) for mesh in _light(shape)]
    return tuple(
        link_visual(robot.model, joint, pieces) for joint, pieces in sorted(shapes.items())
    )


def _light(shape: PlacedSolid) -> list[trimesh.Trimesh]:
    """Its meshes; of one with many faces its convex hull, as which the trunk is simulated, too."""
    import trimesh

    meshes = list(shape.meshes())
    if sum(len(mesh.faces) for mesh in meshes) <= _MANY_FACES:
        return meshes
    hull = trimesh.convex.convex_hull(shape.corners)
    few = len(hull.faces) <= _HULL_FACES
    return [hull if few else hull.simplify_quadric_decimation(face_count=_HULL_FACES)]


def _grey(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    import trimesh

    plain = trimesh.Trimesh(mesh.vertices, mesh.faces)
    smooth = trimesh.graph.smooth_shade(plain, angle=_CREASE, facet_minarea=None)
    colour = np.array([int(255 * share) for share in GREY], dtype=np.uint8)
    return trimesh.Trimesh(
        smooth.vertices,
        smooth.faces,
        vertex_normals=np.asarray(smooth.vertex_normals),
        vertex_colors=np.tile(colour, (len(smooth.vertices), 1)),
        process=False,
    )
