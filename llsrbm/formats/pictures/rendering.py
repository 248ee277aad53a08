"""A robot in motion as MuJoCo's renderer draws it; in a process that has OpenGL."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_HORIZON = [0.914, 0.929, 0.949, 1.0]
_GHOST, _ELLIPSOID = 0.16, 0.13  # opacity
_NO_SHADOW = mujoco.mjtCatBit.mjCAT_DECOR  # such things cast none
_PALETTE_ROW = 64  # colours in a row of a texture
_TILE, _PIXELS = 0.5, 250  # m and pixels of the ground's pattern
_BEHIND = 0.012  # m by which a ghost is further away than what it would flicker through
_SAMPLES, _SHADOW = 4, 2048  # of a pixel; pixels
_PROCESSORS = ("llvmpipe", "softpipe", "swrast", "swr")  # what Mesa calls drawing without a card
_FEW_PIXELS = 640 * 360  # a processor smooths edges in pictures up to that: it doubles the time
_PIECE = 1 / 30  # s, of a trail


def draw_film(film: dict[str, Any], drawn_by: str, write: Callable[[bytes], object]) -> None:
    """Draw a film of `llsrbm.formats.pictures.video`, picture after picture.

    `drawn_by`: what OpenGL calls what it draws with; `write` takes each picture: rows of red,
    green, blue from the top.
    """
    width, height = film["size"]
    smooth = width * height <= _FEW_PIXELS or not drawn_by.startswith(_PROCESSORS)
    model = _model(film, _SAMPLES if smooth else 0)
    with mujoco.Renderer(model, height, width, max_geom=3000) as renderer:
        data, camera = mujoco.MjData(model), mujoco.MjvCamera()
        camera.lookat, camera.distance = film["target"], film["distance"]
        # MuJoCo's angles are those of where a camera looks.
        camera.azimuth, camera.elevation = film["azimuth"] + 180.0, -film["elevation"]
        for k in range(len(film["time"])):
            _place_bodies(data, film, k)
            mujoco.mj_kinematics(model, data)
            mujoco.mj_camlight(model, data)
            renderer.update_scene(data, camera)
            for geom in renderer.scene.geoms[: renderer.scene.ngeom]:
                if geom.rgba[3] < 1:
                    geom.category = _NO_SHADOW
            _Overlays(renderer.scene, film).add(k)
            for flag in (mujoco.mjtRndFlag.mjRND_HAZE, mujoco.mjtRndFlag.mjRND_SHADOW):
                renderer.scene.flags[flag] = True
            write(renderer.render().tobytes())


def _place_bodies(data: mujoco.MjData, film: dict[str, Any], k: int) -> None:
    poses = film["solid"][k]
    if "ghost" in film:
        ghost = film["ghost"][k].copy()
        away = ghost[:, :3] - film["eye"]
        ghost[:, :3] += away * (_BEHIND / np.linalg.norm(away, axis=1, keepdims=True))
        poses = np.vstack([poses, ghost])
    data.mocap_pos[:], data.mocap_quat[:] = poses[:, :3], poses[:, 3:]


class _Overlays:
    """Everything but the robot."""

    def __init__(self, scene: mujoco.MjvScene, film: dict[str, Any]) -> None:
        self._scene, self._film = scene, film

    def add(self, k: int) -> None:
        """Add all of picture `k` to the scene."""
        film, kinds, turn = self._film, mujoco.mjtGeom, np.empty(9)
        rgb = film["colours"]
        for block in film["blocks"]:
            if block["from_s"] <= film["time"][k] < block["until_s"]:
                c, s = np.cos(block["yaw"]), np.sin(block["yaw"])
                about_z = np.array([c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0])
                half, category = block["size"] / 2, mujoco.mjtCatBit.mjCAT_STATIC
                look = [*rgb["block"], 1.0]
                self._shape(kinds.mjGEOM_BOX, half, block["centre"], about_z, look, category)
        for start, force in film["force"][k].reshape(-1, 2, 3):
            if np.linalg.norm(force) > film["least_force"]:
                end, look = start + force * film["arrow_per_newton"], [*rgb["force"], 1.0]
                self._line(kinds.mjGEOM_ARROW, film["thickness"], start, end, look)
        self._trails(k, [*rgb["com"], 0.9], [*rgb["foot"], 0.8])
        axes, quat = np.split(film["ellipsoid"][k], [3])
        mujoco.mju_quat2Mat(turn, quat)
        look = [*rgb["ellipsoid"], _ELLIPSOID]
        self._shape(kinds.mjGEOM_ELLIPSOID, axes, film["com"][k], turn, look)

    def _trails(self, k: int, com: list[float], foot: list[float]) -> None:
        """As far as the robot has come."""
        film, line = self._film, mujoco.mjtGeom.mjGEOM_LINE
        # Few pieces: each costs as much as a body.
        stride = max(1, round(_PIECE / max(float(np.diff(film["time"][:2]).sum()), 1e-3)))
        for a in range(0, k, stride):
            b = min(a + stride, k)
            self._line(line, 3.0, film["com"][a], film["com"][b], com)
            if film["flight"][a] and film["flight"][b]:
                for start, end in zip(film["foot"][a], film["foot"][b], strict=True):
                    self._line(line, 2.0, start, end, foot)

    def _shape(
        self,
        kind: Any,
        size: Array,
        place: Array,
        turn: Array,
        rgba: list[float],
        category: Any = _NO_SHADOW,
    ) -> None:
        if (geom := self._next()) is not None:
            mujoco.mjv_initGeom(geom, kind, size, place, turn, rgba)
            geom.specular, geom.shininess = 0.2, 0.3
            geom.category = category

    def _line(self, kind: Any, width: float, start: Array, end: Array, rgba: list[float]) -> None:
        if (geom := self._next()) is not None:
            mujoco.mjv_initGeom(geom, kind, np.zeros(3), np.zeros(3), np.eye(3).ravel(), rgba)
            mujoco.mjv_connector(geom, kind, width, start, end)
            geom.category = _NO_SHADOW

    def _next(self) -> mujoco.MjvGeom | None:
        if self._scene.ngeom >= self._scene.maxgeom:
            return None
        self._scene.ngeom += 1
        return self._scene.geoms[self._scene.ngeom - 1]


def _model(film: dict[str, Any], samples: int) -> mujoco.MjModel:
    """Bodies that are put where they are, ground, light; nothing that could move by itself."""
    spec = mujoco.MjSpec()
    visual, light = spec.visual, spec.visual.headlight
    visual.global_.offwidth, visual.global_.offheight = film["size"]
    visual.global_.fovy = film["field_of_view"]
    visual.quality.offsamples, visual.quality.shadowsize = samples, _SHADOW
    light.ambient, light.diffuse, light.specular = [0.42] * 3, [0.32] * 3, [0.05] * 3
    visual.rgba.haze = _HORIZON
    visual.map.haze, visual.map.shadowclip = 0.45, 1.0
    visual.map.znear, visual.map.zfar = 0.02, 40.0
    target, extent = film["target"], film["extent"]
    spec.stat.extent, spec.stat.center = extent, target
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT,
        rgb1=_HORIZON[:3],
        rgb2=_HORIZON[:3],
        width=16,
        height=96,
    )
    to_light = np.array([0.35, -0.55, 1.0])
    spec.worldbody.add_light(
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=target + 2 * extent * to_light / np.linalg.norm(to_light),
        dir=-to_light,
        diffuse=[0.55] * 3,
        specular=[0.15] * 3,
        castshadow=True,
    )
    _add_ground(spec, film["ground"])
    for i, mesh in enumerate(film["meshes"]):
        _add_painted_mesh(spec, mesh, i)
        _add_body(spec, meshname=f"mesh{i}", material=f"paint{i}")
    for i, mesh in enumerate(film["coarse"]):
        _add_mesh(spec, mesh, f"coarse{i}")
        _add_body(spec, meshname=f"coarse{i}", rgba=[*film["colours"]["planned"], _GHOST])
    return spec.compile()


def _add_body(spec: mujoco.MjSpec, **look: Any) -> None:
    body = spec.worldbody.add_body(mocap=True)
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, contype=0, conaffinity=0, **look)


def _add_ground(spec: mujoco.MjSpec, height: float) -> None:
    n = _PIXELS
    tile = np.empty((n, n, 3))
    tile[:] = [0.93, 0.94, 0.952]
    for every, width, colour in ((n // 5, 1, [0.84, 0.86, 0.89]), (n, 3, [0.66, 0.70, 0.76])):
        on = (np.arange(n) + width // 2) % every < width
        tile[on], tile[:, on] = colour, colour
    material = _add_material(spec, "grid", tile)
    material.texuniform, material.texrepeat = True, [1 / _TILE, 1 / _TILE]
    material.specular = 0.0
    plane = mujoco.mjtGeom.mjGEOM_PLANE
    spec.worldbody.add_geom(type=plane, size=[0, 0, 0.05], pos=[0, 0, height], material="grid")


def _add_mesh(spec: mujoco.MjSpec, mesh: dict[str, Any], name: str) -> mujoco.MjsMesh:
    faces = mesh["faces"].ravel().astype(np.int32)
    return spec.add_mesh(
        name=name,
        uservert=mesh["vertices"].ravel(),
        userface=faces,
        usernormal=mesh["normals"].ravel(),
        userfacenormal=faces,
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,  # of any form
    )


def _add_painted_mesh(spec: mujoco.MjSpec, visual: dict[str, Any], i: int) -> None:
    """A mesh and its paint: a texture of colours, of which each face has that of its vertices."""
    of_faces = (255 * visual["rgb"][visual["faces"]].mean(axis=1)).round().astype(np.uint8)
    colours, index = np.unique(of_faces, axis=0, return_inverse=True)
    rows = -(-len(colours) // _PALETTE_ROW)
    texture = np.zeros((rows * _PALETTE_ROW, 3))
    texture[: len(colours)] = colours / 255
    at = np.arange(len(colours))
    places = (np.column_stack([at % _PALETTE_ROW, at // _PALETTE_ROW]) + 0.5) / (_PALETTE_ROW, rows)
    mesh = _add_mesh(spec, visual, f"mesh{i}")
    mesh.usertexcoord = places.ravel()
    mesh.userfacetexcoord = np.repeat(np.ravel(index), 3).astype(np.int32)
    material = _add_material(spec, f"paint{i}", texture.reshape(rows, _PALETTE_ROW, 3))
    material.specular, material.shininess = 0.3, 0.4


def _add_material(spec: mujoco.MjSpec, name: str, picture: Array) -> mujoco.MjsMaterial:
    """A material with a texture, (height, width, 3) from 0 to 1."""
    texture = spec.add_texture(
        name=name,
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        height=picture.shape[0],
        width=picture.shape[1],
        nchannel=3,
    )
    texture.data = (picture * 255).round().astype(np.uint8).tobytes()
    material = spec.add_material(name=name)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
    return material
