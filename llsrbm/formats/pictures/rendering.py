"""A robot in motion as MuJoCo's renderer draws it; in a process that has OpenGL."""

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np

from llsrbm.arrays import Array

_GHOST, _ELLIPSOID = 0.16, 0.13  # opacity
_NO_SHADOW = mujoco.mjtCatBit.mjCAT_DECOR  # such things cast none
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
    model = mujoco.MjModel.from_xml_path(film["scene"])
    _prepare(model, film, _SAMPLES if smooth else 0)
    with np.load(film["motion"]) as archive:
        motion = dict(archive)
    with mujoco.Renderer(model, height, width, max_geom=3000) as renderer:
        data, ghost = mujoco.MjData(model), mujoco.MjData(model)
        camera = mujoco.MjvCamera()
        camera.lookat, camera.distance = film["target"], film["distance"]
        # MuJoCo's angles are those of where a camera looks.
        camera.azimuth, camera.elevation = film["azimuth"] + 180.0, -film["elevation"]
        for k in range(len(motion["time"])):
            _place(model, data, motion["qpos"][k], motion["mocap_pos"][k])
            renderer.update_scene(data, camera)
            overlays = _Overlays(renderer.scene, film)
            overlays.add(k)
            if film["ghost_qpos"] is not None:
                _place(model, ghost, film["ghost_qpos"][k], motion["mocap_pos"][k])
                overlays.add_ghost(model, ghost)
            for flag in (mujoco.mjtRndFlag.mjRND_HAZE, mujoco.mjtRndFlag.mjRND_SHADOW):
                renderer.scene.flags[flag] = True
            write(renderer.render().tobytes())


def _prepare(model: mujoco.MjModel, film: dict[str, Any], samples: int) -> None:
    """Size and view of the pictures; the rest is the exported scene's own."""
    visual = model.vis
    visual.global_.offwidth, visual.global_.offheight = film["size"]
    visual.global_.fovy = film["field_of_view"]
    visual.quality.offsamples, visual.quality.shadowsize = samples, _SHADOW
    visual.map.haze, visual.map.shadowclip = 0.45, 1.0
    visual.map.znear, visual.map.zfar = 0.02, 40.0
    model.stat.extent, model.stat.center[:] = film["extent"], film["target"]


def _place(model: mujoco.MjModel, data: mujoco.MjData, qpos: Array, mocap_pos: Array) -> None:
    data.qpos[:], data.mocap_pos[:] = qpos, mocap_pos
    mujoco.mj_kinematics(model, data)
    mujoco.mj_camlight(model, data)


class _Overlays:
    """Everything but the scene."""

    def __init__(self, scene: mujoco.MjvScene, film: dict[str, Any]) -> None:
        self._scene, self._film = scene, film

    def add(self, k: int) -> None:
        """Add all of picture `k` to the scene."""
        film, kinds, turn = self._film, mujoco.mjtGeom, np.empty(9)
        rgb = film["colours"]
        for start, arrow in zip(film["pressed_at"][k], film["arrows"][k], strict=True):
            if arrow.any():
                # MuJoCo draws an arrow half as long as what it connects.
                end, look = start + 2 * arrow, [*rgb["force"], 1.0]
                self._line(kinds.mjGEOM_ARROW, film["thickness"], start, end, look)
        self._trails(k, [*rgb["com"], 0.9], [*rgb["foot"], 0.8])
        mujoco.mju_quat2Mat(turn, film["ellipsoid_quat"][k])
        look = [*rgb["ellipsoid"], _ELLIPSOID]
        self._shape(kinds.mjGEOM_ELLIPSOID, film["ellipsoid_axes"][k], film["com"][k], turn, look)

    def add_ghost(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """The robot's meshes once more, where `data` has them."""
        look = [*self._film["colours"]["planned"], _GHOST]
        mesh = mujoco.mjtGeom.mjGEOM_MESH
        drawn = (model.geom_type == mesh) & (model.geom_contype == 0)
        for number in np.flatnonzero(drawn):
            place, size = data.geom_xpos[number], model.geom_size[number]
            away = place - self._film["eye"]
            place = place + away * (_BEHIND / np.linalg.norm(away))
            geom = self._shape(mesh, size, place, data.geom_xmat[number], look)
            if geom is not None:
                geom.dataid = 2 * model.geom_dataid[number]  # its hull has the odd number

    def _trails(self, k: int, com: list[float], foot: list[float]) -> None:
        """As far as the robot has come."""
        film, line = self._film, mujoco.mjtGeom.mjGEOM_LINE
        # Few pieces: each costs as much as a body.
        stride = max(1, round(_PIECE * film["fps"]))
        for a in range(0, k, stride):
            b = min(a + stride, k)
            self._line(line, 3.0, film["com"][a], film["com"][b], com)
            if film["flight"][a] and film["flight"][b]:
                for start, end in zip(film["foot"][a], film["foot"][b], strict=True):
                    self._line(line, 2.0, start, end, foot)

    def _shape(
        self, kind: Any, size: Array, place: Array, turn: Array, rgba: list[float]
    ) -> mujoco.MjvGeom | None:
        if (geom := self._next()) is not None:
            mujoco.mjv_initGeom(geom, kind, size, place, turn, rgba)
            geom.specular, geom.shininess = 0.2, 0.3
            geom.category = _NO_SHADOW
        return geom

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
