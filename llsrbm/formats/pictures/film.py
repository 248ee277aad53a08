"""Pictures of a motion, one after the other: drawn by MuJoCo without a screen, then captioned."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.errors import Error, InputError
from llsrbm.formats.base import Options
from llsrbm.formats.pictures.drawing import (
    FIELD_OF_VIEW,
    LEAST_FORCE,
    Bodies,
    Drawing,
    draw,
    view_of,
)
from llsrbm.formats.pictures.process import NO_OPENGL
from llsrbm.look import palette
from llsrbm.look.palette import Rgb
from llsrbm.look.timeline import phase_at
from llsrbm.look.visuals import LinkVisual
from llsrbm.motion.trajectory import Trajectory

if TYPE_CHECKING:
    from PIL import Image

Picture = NDArray[np.uint8]

_BACKENDS = ("egl", "osmesa")  # of MuJoCo, those that need no screen
_LONGEST_LINE = 200  # characters of what went wrong in the other process
_INK, _SOFT_INK = (29, 36, 48), (93, 104, 118)


def pictures(trajectory: Trajectory, options: Options) -> Iterator[Picture]:
    """Pictures (height, width, 3) of a plan or a rollout, 1/fps apart.

    Raises:
        InputError: a size, a camera or a rate that makes no sense; no OpenGL without a screen.
    """
    drawing = draw(trajectory, options.fps, options.pad)
    caption = _Caption(drawing, options.size)
    for k, picture in enumerate(_drawn(_film(drawing, options))):
        yield caption.on(picture, float(drawing.time[k]))


def _film(drawing: Drawing, options: Options) -> dict[str, Any]:
    """Input of the drawing process: the meshes, where everything is, and JSON with the rest."""
    view = view_of(drawing, options.size[0] / options.size[1], options.camera)
    height = float(drawing.robot.com[2])
    facts = {
        "size": options.size,
        "field_of_view": FIELD_OF_VIEW,
        "target": view.target.tolist(),
        "azimuth": view.azimuth,
        "elevation": view.elevation,
        "distance": view.distance,
        "eye": (view.target + view.distance * view.axes[:, 2]).tolist(),
        "extent": 2.2 * height + 0.3,
        "ground": drawing.surroundings.ground,
        "blocks": [
            (
                block.centre.tolist(),
                block.size.tolist(),
                block.yaw,
                block.from_s,
                min(block.until_s, 1e9),
            )
            for block in drawing.surroundings.blocks
        ],
        "arrow_per_newton": drawing.arrow_per_newton,
        "least_force": LEAST_FORCE,
        "thickness": 0.02 * height,
        "meshes": len(drawing.visuals),
        "colours": {
            "planned": _share(palette.PLANNED),
            "ellipsoid": _share(drawing.colour),
            "force": _share(palette.FORCE),
            "com": _share(palette.COM),
            "foot": _share(palette.FOOT),
            "block": _share(palette.BLOCK),
        },
    }
    film: dict[str, Any] = {
        "facts": np.array(json.dumps(facts)),
        "time": drawing.time,
        "solid": _poses(drawing.solid, drawing.visuals),
        "com": drawing.solid.com,
        "axes": drawing.axes,
        "axes_quat": drawing.axes_quat,
        "foot": drawing.foot,
        "flight": drawing.flight,
        "force": drawing.force,
        "pressed_at": drawing.pressed_at,
    }
    film |= _meshes("mesh", drawing.visuals)
    if drawing.ghost is not None:
        film["ghost"] = _poses(drawing.ghost, drawing.visuals)
        film |= _meshes("coarse", drawing.coarse_visuals)
    return film


def _meshes(name: str, visuals: tuple[LinkVisual, ...]) -> dict[str, Any]:
    return {
        f"{name}{i}_{part}": getattr(visual, part)
        for i, visual in enumerate(visuals)
        for part in ("vertices", "normals", "faces", "rgb")
    }


def _poses(bodies: Bodies, visuals: tuple[LinkVisual, ...]) -> NDArray[np.float64]:
    """(K, bodies with meshes, 7): position and quaternion."""
    index = [visual.joint_id - 1 for visual in visuals]
    return np.concatenate([bodies.position[:, index], bodies.quat[:, index]], axis=2)


def _drawn(film: dict[str, Any]) -> Iterator[Picture]:
    """The film's pictures, from a process that is ended with the iteration."""
    width, height = json.loads(str(film["facts"]))["size"]
    chosen = os.environ.get("MUJOCO_GL", "").lower()
    backends = (chosen,) if chosen in _BACKENDS else _BACKENDS
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.npz"
        np.savez(path, **film)
        output = ""
        for backend in backends:
            status, output = yield from _drawn_with(backend, path, width, height, len(film["time"]))
            if status == 0:
                return
            if status != NO_OPENGL:
                raise Error(f"drawing pictures failed: {_last_line(output)}")
    raise InputError(
        f"pictures cannot be drawn without a screen: no OpenGL ({_last_line(output)}); expected "
        "EGL or OSMesa, on Debian and Ubuntu: apt install libegl1 libgl1-mesa-dri, or libosmesa6"
    )


def _last_line(output: str) -> str:
    """Of what a process wrote when it gave up."""
    lines = output.strip().splitlines()
    return lines[-1][:_LONGEST_LINE] if lines else "nothing was said"


def _drawn_with(
    backend: str, path: Path, width: int, height: int, count: int
) -> Any:  # a generator of pictures that returns exit status and stderr
    environment = {k: v for k, v in os.environ.items() if k != "PYOPENGL_PLATFORM"}
    environment["MUJOCO_GL"] = backend
    command = [sys.executable, "-m", "llsrbm.formats.pictures.process", str(path)]
    with tempfile.TemporaryFile() as complaints:
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=complaints, env=environment
        )
        try:
            assert process.stdout is not None
            for _ in range(count):
                data = process.stdout.read(3 * width * height)
                if len(data) < 3 * width * height:
                    break
                yield np.frombuffer(data, np.uint8).reshape(height, width, 3)
            process.stdout.close()
            status = process.wait()
        finally:
            process.kill()
            process.wait()
        complaints.seek(0)
        return status, complaints.read().decode(errors="replace")


class _Caption:
    """Title, what came of it, time and phase, written into the pictures' upper left corner."""

    def __init__(self, drawing: Drawing, size: tuple[int, int]) -> None:
        from PIL import ImageFont

        self._drawing = drawing
        self._small = size[1] < 240  # nothing could be read
        height = max(10, round(size[1] / 30))
        self._large, self._plain = (ImageFont.load_default(h) for h in (height, 0.8 * height))
        self._step = 1.35 * height
        self._edge = 0.8 * height

    def on(self, picture: Picture, time: float) -> Picture:
        """The picture with its caption."""
        from PIL import Image, ImageDraw

        if self._small:
            return picture
        image: Image.Image = Image.fromarray(picture)
        pen = ImageDraw.Draw(image)
        drawing = self._drawing
        phase = phase_at(drawing.timeline, max(time, 0.0))
        rows = (
            (drawing.title, self._large, _INK),
            (drawing.outcome, self._plain, _SOFT_INK),
            (f"{math.floor(1000 * time + 0.5) / 1000:.2f} s  {phase}", self._plain, _INK),
        )
        for i, (text, font, ink) in enumerate(rows):
            pen.text((self._edge, self._edge + i * self._step), text, ink, font)
        return np.asarray(image)


def _share(colour: Rgb) -> list[float]:
    return [part / 255 for part in colour]
