"""Meshes of a robot, light enough for a browser, and where its bodies are over time.

A URDF's meshes are made for rendering offline (ANYmal B: 400 k faces in 150 parts, with textures).
Here every moving body becomes one mesh: what is hidden inside is left out, parts of one colour are
merged and simplified together, textures become vertex colours. The result is cached.
"""

from __future__ import annotations

import logging
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from llsrbm.arrays import Array
from llsrbm.cache import cache_path, content_key, read_arrays, write_arrays
from llsrbm.errors import RobotFileError
from llsrbm.look.hidden import without_hidden
from llsrbm.look.meshes import coarser, face_shares, simplified
from llsrbm.mechanics import rotation_matrices
from llsrbm.robots.feet import collision_shapes
from llsrbm.robots.robot import Robot
from llsrbm.robots.solids import placed_solids
from llsrbm.robots.urdf import bodies_on

if TYPE_CHECKING:
    import trimesh

VISUALS_VERSION = "14"  # part of the cache key: raise it when the meshes change
FACES = 26_000  # of a whole robot, about; 0.4 MB as viser sends it
COARSE_FACES = 8_000
GREY = (0.58, 0.61, 0.65)  # of shapes that stand in for what is drawn
_BLACK, _ROUGHNESS = 0.17, 0.55  # darkest grey, 0 to 1; 1 reflects nothing
"""A robot with more of them has coarse meshes as well, with a third of the faces or so, for
browsers without a graphics processor."""


_FROM = np.array([0.76, -1.17, 0.36])  # in the robot's size: from the right, ahead and above
_AT = np.array([0.1, 0.0, 0.04])  # likewise, from its middle: it will jump, mostly forward

# Powers of two, so that most bits of the numbers are zero and they compress to half on the wire.
_VERTEX_STEP = 2.0**-13  # m
_NORMAL_STEP = 2.0**-6

_ARRAYS = ("vertices", "normals", "faces", "rgb")

_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class LinkVisual:
    """One moving body's mesh, in the frame of the joint that moves it.

    Attributes:
        link: name of the body's first link in the URDF.
        joint_id: Pinocchio's index of the joint; 1 is the base.
        vertices: (V, 3) m; normals: (V, 3); faces: (F, 3) indices; rgb: (V, 3), 0 to 255.
    """

    link: str
    joint_id: int
    vertices: NDArray[np.float32]
    normals: NDArray[np.float32]
    faces: NDArray[np.uint32]
    rgb: NDArray[np.uint8]

    def mesh(self) -> trimesh.Trimesh:
        """The same as a trimesh with vertex colours and normals."""
        import trimesh

        return trimesh.Trimesh(
            vertices=self.vertices,
            faces=self.faces,
            vertex_normals=self.normals,
            vertex_colors=self.rgb,
            process=False,
        )

    @property
    def paint(self) -> Array:
        """(V, 3) 0 to 1: its colours as pictures have them, in which black is dark grey."""
        return _BLACK + (1 - _BLACK) * (self.rgb / 255.0)

    def glb(self) -> bytes:
        """Binary glTF in its paint, as matt plastic has it.

        Without a material glTF takes a mesh for bare metal, which is black in a room without
        mirrors.
        """
        painted = self.mesh()
        # glTF's colours are proportional to light, not to what an eye sees.
        painted.visual.vertex_colors[:, :3] = np.round(255 * self.paint**2.2)
        return painted.export(file_type="glb", include_normals=True, tree_postprocessor=_matt)


def _matt(tree: dict[str, Any]) -> None:
    plastic = {"metallicFactor": 0.0, "roughnessFactor": _ROUGHNESS}
    give_material(tree, {"pbrMetallicRoughness": plastic})


def give_material(tree: dict[str, Any], material: dict[str, Any]) -> None:
    """Give all of a glTF's meshes one material."""
    tree["materials"] = [material]
    for mesh in tree["meshes"]:
        for primitive in mesh["primitives"]:
            primitive["material"] = 0


def link_visuals(robot: Robot, *, coarse: bool = False) -> tuple[LinkVisual, ...]:
    """A mesh for each moving body that has one, from the cache if made before.

    `coarse`: with fewer faces, see `COARSE_FACES`. Raises `RobotFileError`: a mesh cannot be read,
    or there is nothing to draw.
    """
    path = _entry(robot, coarse=coarse)
    stored = read_arrays(path)
    if stored is not None:
        return _decode(stored)
    _log.info("preparing the meshes of %s", robot.name)
    visuals = _coarser(link_visuals(robot), robot) if coarse else _prepare(robot)
    write_arrays(path, _encode(visuals))
    return visuals


def needs_preparation(robot: Robot) -> bool:
    """True if `link_visuals` would take seconds: meshes that were not prepared on this machine."""
    return bool(robot.urdf.meshes) and not _entry(robot, coarse=True).exists()


def forward_kinematics(
    robot: Robot, base_position: ArrayLike, base_quat: ArrayLike, joint_position: ArrayLike
) -> tuple[Array, Array]:
    """Where every moving body is, for K moments at once; bodies in Pinocchio's joint order.

    Of base_position (K, 3) m, base_quat (K, 4) w, x, y, z and joint_position (K, J).

    Returns:
        position (K, 1 + J, 3) m and quaternion (K, 1 + J, 4) w, x, y, z in the world frame: the
        pose of joint j is at index j - 1, so a `LinkVisual` belongs at `joint_id - 1`.
    """
    quat = np.asarray(base_quat, dtype=float)
    coordinates = np.hstack([base_position, quat[:, [1, 2, 3, 0]], joint_position])
    model, data = robot.model, robot.model.createData()
    poses = np.empty((len(quat), model.njoints - 1, 7))
    for k, q in enumerate(coordinates):
        pin.forwardKinematics(model, data, q)
        for body, pose in enumerate(data.oMi[1:]):
            poses[k, body] = pin.SE3ToXYZQUAT(pose)
    return poses[..., :3], poses[..., [6, 3, 4, 5]]


@lru_cache(maxsize=16)
def default_pose(robot: Robot) -> tuple[Array, Array]:
    """Poses of all bodies in the default posture, (B, 3) m and (B, 4)."""
    position, wxyz = forward_kinematics(
        robot, robot.base_position[None], [[1.0, 0.0, 0.0, 0.0]], robot.posture[None, 7:]
    )
    return position[0], wxyz[0]


@lru_cache(maxsize=8)
def viewpoint(robot: Robot) -> tuple[Array, Array]:
    """Where the camera is and where it looks at, (3,) m, for a robot in its default posture.

    The robot fills the same part of the picture whatever its size, with room for a jump.
    """
    position, wxyz = default_pose(robot)
    R = rotation_matrices(wxyz)
    bodies = [(visual.joint_id - 1, visual.vertices) for visual in link_visuals(robot)]
    points = np.concatenate([places @ R[k].T + position[k] for k, places in bodies])
    low, high = points.min(axis=0), points.max(axis=0)
    size = np.linalg.norm(high - low)
    target = (low + high) / 2 + size * _AT
    return target + size * _FROM, target


def _prepare(robot: Robot) -> tuple[LinkVisual, ...]:
    bodies: dict[int, list[trimesh.Trimesh]] = defaultdict(list)
    for (joint, _), part in _coloured_parts(robot).items():
        bodies[joint].append(part)
    seen = {joint: without_hidden(bodies[joint]) for joint in sorted(bodies)}
    shares = iter(face_shares([part for parts in seen.values() for part in parts], FACES))
    size = _size(robot)
    return tuple(
        link_visual(robot.model, joint, [simplified(part, next(shares), size) for part in parts])
        for joint, parts in seen.items()
    )


def _coarser(visuals: tuple[LinkVisual, ...], robot: Robot) -> tuple[LinkVisual, ...]:
    if sum(len(visual.faces) for visual in visuals) <= COARSE_FACES:
        return visuals
    size = _size(robot)
    return tuple(
        link_visual(robot.model, visual.joint_id, [coarser(visual.mesh(), size)])
        for visual in visuals
    )


def link_visual(model: pin.Model, joint: int, pieces: Sequence[trimesh.Trimesh]) -> LinkVisual:
    """One mesh of a body's pieces, which have vertex colours and lie in the joint's frame."""
    first = np.cumsum([0, *(len(piece.vertices) for piece in pieces[:-1])])
    faces = [piece.faces + start for piece, start in zip(pieces, first, strict=True)]
    return LinkVisual(
        link=bodies_on(model, joint)[0].name,
        joint_id=joint,
        vertices=_rounded([piece.vertices for piece in pieces], _VERTEX_STEP),
        normals=_rounded([piece.vertex_normals for piece in pieces], _NORMAL_STEP),
        faces=np.vstack(faces).astype(np.uint32),
        rgb=np.vstack([piece.visual.vertex_colors[:, :3] for piece in pieces]),
    )


def _size(robot: Robot) -> float:
    """Length of the longest leg in the default posture, m."""
    return float(np.linalg.norm(robot.feet - robot.base_position - robot.hips, axis=1).max())


def _rounded(arrays: list[Array], step: float) -> NDArray[np.float32]:
    return (np.round(np.vstack(arrays) / step) * step).astype(np.float32)


def _coloured_parts(robot: Robot) -> dict[tuple[int, Any], trimesh.Trimesh]:
    """Meshes with vertex colours in the joint's frame: one a joint and colour, or texture.

    A body that the URDF draws nothing of has its collision shapes, in grey.
    """
    import trimesh

    found: dict[tuple[int, Any], list[trimesh.Trimesh]] = defaultdict(list)
    solids = placed_solids(robot.urdf, robot.model, "visuals")
    drawn = {solid.joint for solid in solids}
    bare = [solid for solid in collision_shapes(robot) if solid.joint not in drawn]
    if not solids and not bare:
        raise RobotFileError(
            f"{robot.path}: urdf: {robot.urdf_path} has neither visual nor collision shapes; "
            "expected some, or there is nothing to draw"
        )
    for place, solid in enumerate((*solids, *bare)):
        for number, mesh in enumerate(solid.meshes()):
            colours = _vertex_colours(mesh, GREY if solid in bare else solid.solid.colour)
            plain = (colours == colours[0]).all()
            piece = trimesh.Trimesh(
                mesh.vertices, mesh.faces, vertex_colors=colours, process=False, validate=False
            )
            colour = tuple(colours[0].tolist()) if plain else (place, number)
            found[solid.joint, colour].append(piece)
    return {key: trimesh.util.concatenate(pieces) for key, pieces in found.items()}


def _entry(robot: Robot, *, coarse: bool) -> Path:
    kind = "coarse" if coarse else "visuals"
    stamps = robot.urdf.mesh_stamps()
    key = content_key(kind, VISUALS_VERSION, robot.urdf.content, str(FACES), *stamps)
    return cache_path(f"{kind}-{robot.name}", key, ".npz")


def _vertex_colours(mesh: trimesh.Trimesh, urdfs: Sequence[float] | None) -> NDArray[np.uint8]:
    """(V, 3) colours of a mesh: of its texture or its material, else the URDF's, else its own."""
    visual = mesh.visual
    if visual.kind == "texture":
        image = getattr(visual.material, "baseColorTexture", None)
        image = image or getattr(visual.material, "image", None)
        if image is not None and visual.uv is not None:
            colours = np.asarray(visual.to_color().vertex_colors, dtype=np.uint8)
            return colours[:, :3]
        urdfs = [share / 255.0 for share in visual.material.main_color]
    if urdfs is not None:
        colour = np.array([int(255 * share) for share in urdfs[:3]], dtype=np.uint8)
        return np.tile(colour, (len(mesh.vertices), 1))
    return np.asarray(visual.vertex_colors, dtype=np.uint8)[:, :3]


def _encode(visuals: tuple[LinkVisual, ...]) -> dict[str, Any]:
    arrays: dict[str, Any] = {
        "links": np.array([visual.link for visual in visuals], dtype=np.str_),
        "joint_ids": np.array([visual.joint_id for visual in visuals], dtype=np.int64),
    }
    for i, visual in enumerate(visuals):
        arrays |= {f"{name}_{i}": getattr(visual, name) for name in _ARRAYS}
    return arrays


def _decode(stored: dict[str, Any]) -> tuple[LinkVisual, ...]:
    bodies = zip(stored["links"], stored["joint_ids"], strict=True)
    return tuple(
        LinkVisual(str(link), int(joint), **{name: stored[f"{name}_{i}"] for name in _ARRAYS})
        for i, (link, joint) in enumerate(bodies)
    )
