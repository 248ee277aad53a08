"""Mesh files as everything here reads them: collision, pictures and exports alike.

Units and the transforms of a file's nodes count, all of its meshes do. Its statement of which axis
points up does not, as in RViz: URDFs are written for readers that leave meshes as they stand.
"""

from __future__ import annotations

import io
import logging
import xml.etree.ElementTree as ET
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from llsrbm.errors import RobotFileError

if TYPE_CHECKING:
    import trimesh

_POINTER = b"version https://git-lfs"
_MERGED = (".stl", ".obj", ".ply", ".off")  # corners in one place are one, as trimesh has it
_GREY = "0.7 0.7 0.7 1"

_log = logging.getLogger(__name__)


def read_meshes(path: Path) -> tuple[trimesh.Trimesh, ...]:
    """A file's meshes with faces, m, where its nodes put them. Do not change them. Raises
    `RobotFileError`: it cannot be read, has no face, or has corners at no finite place.
    """
    try:
        with path.open("rb") as file:
            start = file.read(len(_POINTER))
        written = path.stat().st_mtime_ns
    except OSError as error:
        raise RobotFileError(f"{path}: this mesh cannot be read: {error.strerror}") from error
    if start == _POINTER:
        raise RobotFileError(f"{path}: Git LFS has not fetched this mesh; run `git lfs pull`")
    return _read(path, written)


@lru_cache(maxsize=4)  # the same file is often one of several links, and is not kept for long
def _read(path: Path, _written: int) -> tuple[trimesh.Trimesh, ...]:
    import trimesh

    try:
        ending = path.suffix.lower()
        # trimesh drops faces with corners that are no numbers if it may merge as it reads.
        scene = _collada(path) if ending == ".dae" else trimesh.load_scene(path, process=False)
        found = [mesh for mesh in scene.dump() if isinstance(mesh, trimesh.Trimesh)]
    except Exception as error:  # whatever a damaged file makes a reader of meshes raise
        reason = " ".join(str(error).split()) or type(error).__name__
        raise RobotFileError(f"{path}: this mesh cannot be read: {reason}") from error
    found = [mesh for mesh in found if len(mesh.faces)]
    if not found:
        raise RobotFileError(f"{path}: this mesh is empty; expected faces")
    if not all(np.isfinite(mesh.vertices).all() for mesh in found):
        raise RobotFileError(f"{path}: this mesh has corners that are no numbers; expected numbers")
    if ending in _MERGED:
        for mesh in found:
            with np.errstate(invalid="ignore"):  # of corners too far away, which are told later
                mesh.process()
    return tuple(found)


def _collada(path: Path) -> trimesh.Scene:
    """A Collada file in m, whose materials cost no face."""
    import trimesh

    root = ET.fromstring(path.read_bytes())  # noqa: S314  a mesh of the user's own robot
    space = root.tag.rpartition("}")[0]
    tags = _Tags(f"{space}}}" if space else "")
    _mend_looks(root, tags, path)

    def load() -> trimesh.Scene:
        return trimesh.load_scene(
            io.BytesIO(ET.tostring(root)),
            file_type="dae",
            resolver=trimesh.resolvers.FilePathResolver(str(path)),
        )

    scene = load()
    if not scene.geometry:  # what is wrong with its materials is something else
        for parent in root.iter():
            for looks in parent.findall(tags("bind_material")):
                parent.remove(looks)
        scene = load()
    unit = root.find(tags("asset", "unit"))
    scale = float(unit.get("meter", "1")) if unit is not None else 1.0
    if scale != 1.0:
        scene.apply_transform(trimesh.transformations.scale_matrix(scale))
    return scene


class _Tags:
    """Names and paths of elements in a file's namespace."""

    def __init__(self, space: str) -> None:
        self._space = space

    def __call__(self, *names: str) -> str:
        return "/".join(self._space + name for name in names)


def _mend_looks(root: ET.Element, tags: _Tags, path: Path) -> None:
    """Make plain what refers to nothing: a reader would drop the faces that it is on.

    Blender wrote files in which a sampler names "image_001-surface" where the surface is called
    "image-surface" (ANYmal B's shanks): there the surface is meant that comes before it.
    """
    images = {image.get("id") for image in root.iter(tags("image"))}
    effects, mended = set(), False
    for effect in root.iter(tags("effect")):
        effects.add(f"#{effect.get('id')}")
        surfaces: list[str] = []
        samplers: dict[str | None, bool] = {}
        for parameter in effect.iter(tags("newparam")):
            start = parameter.find(tags("surface", "init_from"))
            source = parameter.find(tags("sampler2D", "source"))
            if start is not None and start.text in images:
                surfaces.append(parameter.get("sid", ""))
            if source is not None:
                if source.text not in surfaces and surfaces:
                    source.text = surfaces[-1]
                samplers[parameter.get("sid")] = source.text in surfaces
        for slot in effect.iter():
            texture = slot.find(tags("texture"))
            name = None if texture is None else texture.get("texture")
            if texture is not None and not samplers.get(name, name in images):
                slot.clear()
                ET.SubElement(slot, tags("color")).text = _GREY
                mended = True
        for profile in effect.iter():
            for parameter in profile.findall(tags("newparam")):
                image = parameter.find(tags("surface", "init_from"))
                if (image is not None and image.text not in images) or (
                    samplers.get(parameter.get("sid")) is False
                ):
                    profile.remove(parameter)
    materials = set()
    for material in root.iter(tags("material")):
        instance = material.find(tags("instance_effect"))
        if instance is not None and instance.get("url") in effects:
            materials.add(f"#{material.get('id')}")
    for technique in root.iter(tags("technique_common")):
        for instance in technique.findall(tags("instance_material")):
            if instance.get("target") not in materials:
                technique.remove(instance)
                mended = True
    if mended:
        _log.warning("%s: some of its materials refer to nothing; they are drawn in grey", path)
