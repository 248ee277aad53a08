"""Meshes of a robot, light enough for a browser, and where its bodies are over time.

A URDF's meshes are made for rendering offline (ANYmal B: 400 k faces in 150 parts, with textures).
Here every moving body becomes one mesh: parts of one colour are merged and simplified together,
textures become vertex colours. The result is cached.
"""

from __future__ import annotations

import io
import logging
import re
import tempfile
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from llsrbm.cache import cache_path, content_key, read_checked, write_checked
from llsrbm.errors import RobotFileError
from llsrbm.look.meshes import coarser, face_shares, readable, simplified
from llsrbm.robots.robot import Robot

if TYPE_CHECKING:
    import trimesh

Array = NDArray[np.float64]

VISUALS_VERSION = "5"  # part of the cache key: raise it when the meshes change
FACES = 26_000  # of a whole robot, about; 0.4 MB as viser sends it
COARSE_FACES = 8_000
"""A robot with more of them has coarse meshes as well, with a third of the faces or so, for
browsers without a graphics processor."""


# Powers of two, so that most bits of the numbers are zero and they compress to half on the wire.
_VERTEX_STEP = 2.0**-13  # m
_NORMAL_STEP = 2.0**-6

_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class LinkVisual:
    """One moving body's mesh, in the frame of the joint that moves it.

    Attributes:
        link: name of the body's first link in the URDF.
        joint_id: Pinocchio's index of the joint; 1 is the base.
        vertices: (V, 3) m, in the joint's frame.
        normals: (V, 3) unit normals.
        faces: (F, 3) indices.
        rgb: (V, 3) colours, 0 to 255.
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


def link_visuals(
    robot: Robot,
    faces: int = FACES,
    progress: Callable[[float], None] | None = None,
    *,
    coarse: bool = False,
) -> tuple[LinkVisual, ...]:
    """A mesh for each moving body that has one, from the cache if made before.

    Args:
        robot: the robot.
        faces: about how many faces the whole robot shall have.
        progress: called with the fraction done, 0 to 1.
        coarse: made of these with fewer faces, see `COARSE_FACES`.

    Raises:
        RobotFileError: the URDF names a mesh that is missing or cannot be read.
    """
    report = progress or _silent
    report(0.0)
    path = _entry(robot, faces, coarse=coarse)
    stored = read_checked(path)
    if stored is not None:
        visuals = _decode(stored)
    else:
        _log.info("preparing the meshes of %s", robot.name)
        if coarse:
            visuals = _coarser(link_visuals(robot, faces, report), robot)
        else:
            visuals = _prepare(robot, faces, report)
        write_checked(path, _encode(visuals))
    report(1.0)
    return visuals


def link_visuals_at_hand(robot: Robot, *, coarse: bool = False) -> tuple[LinkVisual, ...] | None:
    """As `link_visuals`, but None if they would have to be made first, which takes seconds."""
    stored = read_checked(_entry(robot, FACES, coarse=coarse))
    return None if stored is None else _decode(stored)


def needs_preparation(robot: Robot) -> bool:
    """True if `link_visuals` would take seconds: meshes that were not prepared on this machine."""
    return bool(mesh_files(robot)) and not _entry(robot, FACES, coarse=True).exists()


def mesh_files(robot: Robot) -> list[str]:
    """Names of the meshes in the URDF."""
    urdf = robot.urdf_path.read_text(encoding="utf-8")
    return re.findall(r'filename\s*=\s*["\']([^"\']+)["\']', urdf)


def forward_kinematics(
    robot: Robot, base_position: ArrayLike, base_quat: ArrayLike, joint_position: ArrayLike
) -> tuple[Array, Array]:
    """Where every moving body is, for K moments at once; bodies in Pinocchio's joint order.

    Args:
        robot: the robot.
        base_position: (K, 3) m; base_quat: (K, 4) w, x, y, z; joint_position: (K, J).

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


def _prepare(robot: Robot, faces: int, report: Callable[[float], None]) -> tuple[LinkVisual, ...]:
    parts = _coloured_parts(robot)
    report(0.3)
    shares = face_shares(list(parts.values()), faces)
    size = _size(robot)
    pieces: dict[int, list[trimesh.Trimesh]] = defaultdict(list)
    for done, ((joint, _), part, share) in enumerate(
        zip(parts, parts.values(), shares, strict=True), start=1
    ):
        pieces[joint].append(simplified(part, share, size))
        report(0.3 + 0.7 * done / len(parts))
    visuals = []
    for joint in sorted(pieces):
        body = pieces[joint]
        first = np.cumsum([0, *(len(piece.vertices) for piece in body)])
        visuals.append(
            LinkVisual(
                link=link_name(robot.model, joint),
                joint_id=joint,
                vertices=_rounded([piece.vertices for piece in body], _VERTEX_STEP),
                normals=_rounded([piece.vertex_normals for piece in body], _NORMAL_STEP),
                faces=np.vstack(
                    [piece.faces + start for piece, start in zip(body, first, strict=False)]
                ).astype(np.uint32),
                rgb=np.vstack([piece.visual.vertex_colors[:, :3] for piece in body]),
            )
        )
    return tuple(visuals)


def _coarser(visuals: tuple[LinkVisual, ...], robot: Robot) -> tuple[LinkVisual, ...]:
    """The same bodies with fewer faces, if they have many."""
    if sum(len(visual.faces) for visual in visuals) <= COARSE_FACES:
        return visuals
    coarse = []
    for visual in visuals:
        mesh = coarser(visual.mesh(), _size(robot))
        coarse.append(
            replace(
                visual,
                vertices=_rounded([mesh.vertices], _VERTEX_STEP),
                normals=_rounded([mesh.vertex_normals], _NORMAL_STEP),
                faces=np.asarray(mesh.faces, dtype=np.uint32),
                rgb=mesh.visual.vertex_colors[:, :3],
            )
        )
    return tuple(coarse)


def _size(robot: Robot) -> float:
    """Length of the longest leg in the default posture, m."""
    return float(np.linalg.norm(robot.feet - robot.base_position - robot.hips, axis=1).max())


def _rounded(arrays: list[Array], step: float) -> NDArray[np.float32]:
    return (np.round(np.vstack(arrays) / step) * step).astype(np.float32)


def _coloured_parts(robot: Robot) -> dict[tuple[int, Any], trimesh.Trimesh]:
    """Meshes with vertex colours in the joint's frame: one a joint and colour, or texture."""
    import trimesh

    scene = _load_scene(robot)
    model = robot.model
    found: dict[tuple[int, Any], list[trimesh.Trimesh]] = defaultdict(list)
    for node in scene.graph.nodes_geometry:
        link = scene.graph.transforms.parents[node]
        while not model.existFrame(link, pin.FrameType.BODY):
            link = scene.graph.transforms.parents[link]
        frame = model.frames[model.getFrameId(link, pin.FrameType.BODY)]
        T_link_part, geometry = scene.graph.get(node, frame_from=link)
        mesh = scene.geometry[geometry]
        if not isinstance(mesh, trimesh.Trimesh) or len(mesh.faces) == 0:
            continue
        colours = _vertex_colours(mesh)
        plain = (colours == colours[0]).all()
        piece = trimesh.Trimesh(
            mesh.vertices, mesh.faces, vertex_colors=colours, process=False, validate=False
        )
        piece.apply_transform(frame.placement.homogeneous @ T_link_part)
        colour = tuple(colours[0].tolist()) if plain else node
        found[frame.parentJoint, colour].append(piece)
    if not found:
        _log.warning("%s has no visual meshes; there is nothing to draw", robot.urdf_path)
    return {key: trimesh.util.concatenate(pieces) for key, pieces in found.items()}


def _load_scene(robot: Robot) -> trimesh.Scene:
    import yourdfpy

    with tempfile.TemporaryDirectory() as scratch:
        files: dict[str, Path] = {}

        def resolve(fname: str) -> str:
            if fname not in files:
                found = _mesh_path(robot, fname)
                if found is None:
                    raise RobotFileError(
                        f"{robot.path}: urdf: {robot.urdf_path} names a mesh that is missing: "
                        f"{fname}"
                    )
                files[fname] = readable(found, Path(scratch))
            return str(files[fname])

        loader = yourdfpy.URDF.load(
            str(robot.urdf_path), filename_handler=resolve, load_collision_meshes=False
        )
    scene = loader.scene
    drawn = {scene.graph.transforms.parents[node] for node in scene.graph.nodes_geometry}
    for link in loader.robot.links:
        if link.visuals and link.name not in drawn:
            _log.warning("nothing could be read from the visuals of link %s", link.name)
    return scene


def _mesh_path(robot: Robot, name: str) -> Path | None:
    """File of a mesh as a URDF names it, or None if there is none."""
    relative = name.removeprefix("package://").removeprefix("file://")
    candidates = [robot.urdf_path.parent / relative]
    candidates += [directory / relative for directory in robot.package_dirs]
    return next((candidate for candidate in candidates if candidate.is_file()), None)


def _entry(robot: Robot, faces: int, *, coarse: bool) -> Path:
    """Where the cache has the meshes, if it has them."""
    kind = "coarse" if coarse else "visuals"
    urdf = robot.urdf_path.read_text(encoding="utf-8")
    key = content_key(kind, VISUALS_VERSION, urdf, str(faces), *_mesh_stamps(robot))
    return cache_path(f"{kind}-{robot.name}", key, ".npz")


def _mesh_stamps(robot: Robot) -> list[str]:
    """Size and date of each mesh, so that a changed mesh is prepared anew."""
    stamps = []
    for name in mesh_files(robot):
        path = _mesh_path(robot, name)
        if path is not None:
            status = path.stat()
            stamps.append(f"{name} {status.st_size} {status.st_mtime_ns}")
    return stamps


def _vertex_colours(mesh: trimesh.Trimesh) -> NDArray[np.uint8]:
    """(V, 3) colours of a mesh, out of its texture, its material or its faces."""
    visual = mesh.visual
    if visual.kind == "texture":
        image = getattr(visual.material, "baseColorTexture", None)
        image = image or getattr(visual.material, "image", None)
        if image is None or visual.uv is None:
            colour = np.asarray(visual.material.main_color, dtype=np.uint8)[:3]
            return np.tile(colour, (len(mesh.vertices), 1))
        visual = visual.to_color()
    return np.asarray(visual.vertex_colors, dtype=np.uint8)[:, :3]


def link_name(model: pin.Model, joint: int) -> str:
    """First body of the URDF that the joint moves."""
    return next(
        frame.name
        for frame in model.frames
        if frame.type == pin.FrameType.BODY and frame.parentJoint == joint
    )


def _encode(visuals: tuple[LinkVisual, ...]) -> bytes:
    arrays: dict[str, Any] = {
        "links": np.array([visual.link for visual in visuals], dtype=np.str_),
        "joint_ids": np.array([visual.joint_id for visual in visuals], dtype=np.int64),
    }
    for i, visual in enumerate(visuals):
        for name in ("vertices", "normals", "faces", "rgb"):
            arrays[f"{name}_{i}"] = getattr(visual, name)
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def _decode(data: bytes) -> tuple[LinkVisual, ...]:
    with np.load(io.BytesIO(data), allow_pickle=False) as stored:
        return tuple(
            LinkVisual(
                link=str(link),
                joint_id=int(joint),
                vertices=stored[f"vertices_{i}"],
                normals=stored[f"normals_{i}"],
                faces=stored[f"faces_{i}"],
                rgb=stored[f"rgb_{i}"],
            )
            for i, (link, joint) in enumerate(
                zip(stored["links"], stored["joint_ids"], strict=True)
            )
        )


def _silent(_: float) -> None:
    pass
