"""Meshes of overlays as binary glTF, 1 m large, for scales to stretch; and their attitudes."""

from __future__ import annotations

from functools import cache, lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from app.motion.colours import Rgb, linear
from llsrbm.arrays import Array
from llsrbm.look.visuals import give_material

if TYPE_CHECKING:
    import trimesh


_HEAD = 0.2  # of an arrow, share of its length
_SHAFT = 0.008  # m, radius of an arrow's shaft; its head is 2.5 times as wide
_DARKEST = 0.55  # opacity of the middle of a soft disc
_AXIS = 0.06  # share of an axis' length that it is thick


def solid(
    mesh: trimesh.Trimesh,
    colour: Rgb,
    opacity: float = 1.0,
    *,
    sharp: bool = False,
    both_sides: bool = True,
) -> bytes:
    """A mesh in one colour; `sharp`: its edges are seen, `both_sides`: its inside, too."""
    import trimesh
    from trimesh.visual.material import PBRMaterial

    if sharp:
        mesh = mesh.copy()
        mesh.unmerge_vertices()
    material = PBRMaterial(
        baseColorFactor=[*linear(colour), opacity],
        metallicFactor=0.0,
        roughnessFactor=0.9,
        alphaMode="BLEND" if opacity < 1 else "OPAQUE",
        doubleSided=both_sides,
    )
    drawn = trimesh.Trimesh(
        vertices=mesh.vertices,
        faces=mesh.faces,
        vertex_normals=mesh.vertex_normals,
        visual=trimesh.visual.TextureVisuals(material=material),
        process=False,
    )
    return drawn.export(file_type="glb")


@lru_cache(maxsize=8)
def arrow(colour: Rgb) -> bytes:
    """From the origin along z."""
    import trimesh

    body = trimesh.creation.cylinder(_SHAFT, 1 - _HEAD, sections=8)
    body.apply_translation([0.0, 0.0, (1 - _HEAD) / 2])
    tip = trimesh.creation.cone(2.5 * _SHAFT, _HEAD, sections=10)
    tip.apply_translation([0.0, 0.0, 1 - _HEAD])
    return solid(trimesh.util.concatenate([body, tip]), colour)


@lru_cache(maxsize=8)
def rod(colour: Rgb) -> bytes:
    """From the origin along z, of radius 1."""
    import trimesh

    body = trimesh.creation.cylinder(1.0, 1.0, sections=6)
    body.apply_translation([0.0, 0.0, 0.5])
    return solid(body, colour)


@lru_cache(maxsize=4)
def pyramid(colour: Rgb, opacity: float) -> bytes:
    """Upside down: its tip in the origin, its base the square |x|, |y| <= 1 at z = 1, open."""
    import trimesh

    corners = [[0, 0, 0], [1, 1, 1], [-1, 1, 1], [-1, -1, 1], [1, -1, 1]]
    sides = trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]], process=False)
    return solid(sides, colour, opacity, sharp=True)


@lru_cache(maxsize=4)
def bar(colour: Rgb) -> bytes:
    """A flat strip along x from -1/2 to 1/2, as wide and as thick as is set by its scale."""
    import trimesh

    return solid(trimesh.creation.box(extents=[1.0, 1.0, 1.0]), colour, sharp=True)


@lru_cache(maxsize=4)
def disc(colour: Rgb) -> bytes:
    """Disc of radius 1 in the plane z = 0."""
    import trimesh

    return solid(trimesh.creation.cylinder(1.0, 0.2, sections=20), colour)


AXES: tuple[Rgb, ...] = ((214, 60, 60), (60, 170, 80), (60, 100, 220))
"""Colours of x, y and z."""


@lru_cache(maxsize=1)
def triad() -> bytes:
    """Axes: x red, y green, z blue."""
    import trimesh

    axes = []
    for axis, colour in enumerate(AXES):
        extents, middle = np.full(3, _AXIS), np.zeros(3)
        extents[axis], middle[axis] = 1.0, 0.5
        box = trimesh.creation.box(extents=extents)
        box.apply_translation(middle)
        box.unmerge_vertices()
        box.visual.vertex_colors = np.tile([*colour, 255], (len(box.vertices), 1)).astype(np.uint8)
        axes.append(box)
    mesh = trimesh.util.concatenate(axes)
    return mesh.export(file_type="glb", include_normals=True)


@cache
def soft_disc() -> bytes:
    """A dark disc of radius 1 at z = 0 that fades towards its edge."""
    import trimesh

    rings, sections = 5, 24
    radius = np.linspace(0.0, 1.0, rings + 1)[1:]
    angle = np.linspace(0.0, 2 * np.pi, sections, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(sections)], axis=1)
    vertices = np.concatenate([np.zeros((1, 3)), *(r * ring for r in radius)])
    share = np.concatenate([[0.0], np.repeat(radius, sections)])
    # A smooth step: neither the middle nor the edge shows.
    alpha = 1 - share**2 * (3 - 2 * share)
    first = 1 + sections * np.arange(rings)
    step = np.arange(sections)
    after = (step + 1) % sections
    faces = [np.stack([np.zeros(sections, int), 1 + step, 1 + after], axis=1)]
    for inner, outer in pairwise(first):
        faces.append(np.stack([inner + step, outer + step, outer + after], axis=1))
        faces.append(np.stack([inner + step, outer + after, inner + after], axis=1))
    rgba = np.zeros((len(vertices), 4), dtype=np.uint8)
    rgba[:, 3] = np.round(255 * _DARKEST * alpha)
    mesh = trimesh.Trimesh(vertices, np.concatenate(faces), vertex_colors=rgba, process=False)
    return mesh.export(file_type="glb", tree_postprocessor=_blended)


def _blended(tree: dict[str, Any]) -> None:
    """Have a mesh's vertices give its opacity, too; whatever the light, it is as dark."""
    tree["extensionsUsed"] = ["KHR_materials_unlit"]
    give_material(tree, {"alphaMode": "BLEND", "extensions": {"KHR_materials_unlit": {}}})


def x_to(along: Array) -> Array:
    """Quaternions (F, 4) that turn x to the directions `along` (F, 3) and keep y level."""
    yaw = np.arctan2(along[:, 1], along[:, 0]) / 2
    pitch = -np.arctan2(along[:, 2], np.linalg.norm(along[:, :2], axis=1)) / 2
    cy, sy, cp, sp = np.cos(yaw), np.sin(yaw), np.cos(pitch), np.sin(pitch)
    return np.stack([cy * cp, -sy * sp, cy * sp, sy * cp], axis=1)
