"""Videos and moving pictures: drawn by MuJoCo without a screen, then captioned."""

import math
import os
import pickle
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from ctypes.util import find_library
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.analysis.wording import outcome_words
from llsrbm.errors import Error, InputError
from llsrbm.formats.base import Extra, Format, Options, Purpose
from llsrbm.formats.mujoco.folder import MOTION, MUJOCO, SCENE, states_in_model_order
from llsrbm.formats.pictures.drawing import FIELD_OF_VIEW, Drawing, draw, view_of
from llsrbm.formats.pictures.process import NO_OPENGL
from llsrbm.look import palette
from llsrbm.look.timeline import phase_at
from llsrbm.look.titles import title
from llsrbm.motion.trajectory import Trajectory

Picture = NDArray[np.uint8]

_FOLDER, _FILM = "mujoco", "film"
# MuJoCo's that need no screen; "": its own of macOS and Windows.
_BACKENDS = ("egl", "osmesa") if sys.platform == "linux" else ("",)
_EXPECTED = (
    "EGL or OSMesa, on Debian and Ubuntu: apt install libegl1 libgl1-mesa-dri, or libosmesa6"
)
_LONGEST_LINE = 200  # characters of what went wrong in the other process
_INK, _SOFT_INK = (29, 36, 48), (93, 104, 118)
_FASTEST_VIDEO = 240.0  # pictures/s; players refuse more
_QUALITY = "18"  # x264's constant rate factor: hardly to be told from what was drawn
_FINEST = 10_000  # denominator of a rate
_FASTEST_GIF = 50.0  # pictures/s; browsers slow down what is faster
_COLOURS = 255
_LOOKED_AT = 6  # pictures that the colours are taken from
_ROUNDED = 4  # of 256 shades: shading that nobody sees would take most of the file


def pictures(trajectory: Trajectory, options: Options) -> Iterator[Picture]:
    """Pictures (height, width, 3) of a plan or a rollout, 1/fps apart. Raises `InputError`: a size,
    a camera or a rate that makes no sense; no OpenGL without a screen.
    """
    drawing = draw(trajectory, options.fps, options.pad)
    caption = _Caption(drawing, options.size)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder)
        MUJOCO.write(trajectory, path / _FOLDER, Options(fps=options.fps, pad=options.pad))
        (path / _FILM).write_bytes(pickle.dumps(_film(drawing, options, path / _FOLDER)))
        shown = _drawn(path / _FILM, options.size, len(drawing.solid.time))
        for k, picture in enumerate(shown):
            yield caption.on(picture, float(drawing.solid.time[k]))


def _film(drawing: Drawing, options: Options, exported: Path) -> dict[str, Any]:
    solid, ghost = drawing.solid, drawing.ghost
    view = view_of(drawing, options.size[0] / options.size[1], options.camera)
    height = float(solid.robot.com[2])
    # As far as there are shadows: about the robot, of a route everywhere where it stands.
    along = float(np.ptp(solid.com, axis=0).max()) / 2
    shades = {
        "planned": palette.PLANNED,
        "ellipsoid": palette.PLANNED if ghost is None else palette.SIMULATED,
        "force": palette.FORCE,
        "com": palette.COM,
        "foot": palette.FOOT,
    }
    return {
        "scene": str(exported / SCENE),
        "motion": str(exported / MOTION),
        "ghost_qpos": None if ghost is None else states_in_model_order(ghost.motion)["qpos"],
        "fps": options.fps,
        "size": options.size,
        "field_of_view": FIELD_OF_VIEW,
        "target": view.target,
        "azimuth": view.azimuth,
        "elevation": view.elevation,
        "distance": view.distance,
        "eye": view.target + view.distance * view.axes[:, 2],
        "extent": 2.2 * height + max(0.3, along),
        "arrows": solid.arrows,
        "pressed_at": solid.pressed_at,
        "thickness": 0.02 * height,
        "colours": {name: [part / 255 for part in rgb] for name, rgb in shades.items()},
        "com": solid.com,
        "foot": solid.foot_position,
        "flight": ~solid.contact.any(axis=1),
        "ellipsoid_axes": solid.inertia_axes,
        "ellipsoid_quat": solid.inertia_wxyz,
    }


def _drawn(film: Path, size: tuple[int, int], count: int) -> Iterator[Picture]:
    """The film's pictures, from a process that is ended with the iteration."""
    chosen = os.environ.get("MUJOCO_GL", "").lower()
    reason = ""
    for backend in (chosen,) if chosen in _BACKENDS else _BACKENDS:
        status, output = yield from _drawn_with(backend, film, size, count)
        if status == 0:
            return
        reason = (output.strip().splitlines() or ["no reason is known"])[-1][:_LONGEST_LINE]
        if status != NO_OPENGL:
            raise Error(f"drawing pictures failed: {reason}")
    raise InputError(
        f"pictures cannot be drawn without a screen: no OpenGL ({reason}); expected {_EXPECTED}"
    )


def _drawn_with(
    backend: str, path: Path, size: tuple[int, int], count: int
) -> Any:  # a generator of pictures that returns exit status and stderr
    width, height = size
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
    """Title, outcome, time and phase, written into the pictures' upper left corner."""

    def __init__(self, drawing: Drawing, size: tuple[int, int]) -> None:
        from PIL import ImageFont

        self._drawing = drawing
        self._small = size[1] < 240  # nothing could be read
        height = max(10, round(size[1] / 30))
        self._large, self._plain = (ImageFont.load_default(h) for h in (height, 0.8 * height))
        self._step, self._edge = 1.35 * height, 0.8 * height

    def on(self, picture: Picture, time: float) -> Picture:
        """The picture with its caption."""
        from PIL import Image, ImageDraw

        if self._small:
            return picture
        image: Image.Image = Image.fromarray(picture)
        pen, drawing = ImageDraw.Draw(image), self._drawing
        phase = phase_at(drawing.timeline, max(time, 0.0))
        rows = (
            (title(drawing.trajectory), self._large, _INK),
            (outcome_words(drawing.trajectory), self._plain, _SOFT_INK),
            (f"{math.floor(1000 * time + 0.5) / 1000:.2f} s  {phase}", self._plain, _INK),
        )
        for i, (text, font, ink) in enumerate(rows):
            pen.text((self._edge, self._edge + i * self._step), text, ink, font)
        return np.asarray(image)


def _write_mp4(trajectory: Trajectory, path: Path, options: Options) -> None:
    import av
    from av.video.reformatter import ColorRange, Colorspace

    width, height = options.size
    if width % 2 or height % 2:
        raise InputError(f"size: expected even numbers for a video, got {width}x{height}")
    if not 1 <= options.fps <= _FASTEST_VIDEO:
        raise InputError(f"fps: expected 1 to {_FASTEST_VIDEO:g} for a video, got {options.fps:g}")
    rate = Fraction(options.fps).limit_denominator(_FINEST)
    # The index before the pictures, so that a video on a web page begins at once.
    flags = {"movflags": "faststart"}
    with av.open(str(path), "w", format="mp4", options=flags) as container:
        container.metadata["title"] = title(trajectory)
        container.metadata["comment"] = MP4.described_json(trajectory, options)
        stream = container.add_stream("libx264", rate=rate, options={"crf": _QUALITY})
        stream.width, stream.height = options.size
        stream.pix_fmt = "yuv420p"
        # Named, or players guess by the picture's size, and reds change with it.
        stream.codec_context.colorspace = space = Colorspace.ITU709
        stream.codec_context.color_range = span = ColorRange.MPEG
        for picture in pictures(trajectory, options):
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")
            coded = frame.reformat(format="yuv420p", dst_colorspace=space, dst_color_range=span)
            container.mux(stream.encode(coded))
        container.mux(stream.encode(None))


def _write_gif(trajectory: Trajectory, path: Path, options: Options) -> None:
    from PIL import Image

    if not 1 <= options.fps <= _FASTEST_GIF:
        raise InputError(f"fps: expected 1 to {_FASTEST_GIF:g} for a gif, got {options.fps:g}")
    drawn = list(pictures(trajectory, options))
    chosen = [drawn[k] for k in np.linspace(0, len(drawn) - 1, _LOOKED_AT).round().astype(int)]
    seen = np.vstack([_rounded(picture) for picture in [*chosen, _swatches(options.size)]])
    colours = Image.fromarray(seen).quantize(_COLOURS, Image.Quantize.MEDIANCUT)
    # One table of colours for all, and no dither: what does not move stays as it is.
    frames = [
        Image.fromarray(_rounded(picture)).quantize(palette=colours, dither=Image.Dither.NONE)
        for picture in drawn
    ]
    frames[0].save(
        path,
        format="GIF",
        save_all=True,
        append_images=frames[1:],
        duration=durations(len(frames), options.fps),
        loop=0,
        comment=GIF.described_json(trajectory, options).encode(),
    )


def durations(count: int, fps: float) -> Sequence[int]:
    """Time that each of `count` pictures is shown, ms, whole hundredths of a second."""
    edges = np.round(np.arange(count + 1) * 100 / fps).astype(int)
    return (10 * np.diff(edges)).tolist()


def _swatches(size: tuple[int, int]) -> Picture:
    """Shades of what is small and matters, so that it gets its colours beside so much ground."""
    width, height = size[0], max(1, size[1] // 16)
    shades = np.linspace(0.45, 1.0, 6)[:, None, None] * np.array([palette.FORCE, palette.COM])
    row = np.repeat(shades.reshape(-1, 3), -(-width // 12), axis=0)[:width]
    return np.repeat(row[None].astype(np.uint8), height, axis=0)


def _rounded(picture: Picture) -> Picture:
    return (picture // _ROUNDED * _ROUNDED + _ROUNDED // 2).astype(np.uint8)


@cache
def _check_machine() -> None:
    if sys.platform == "linux" and not any(map(find_library, ("EGL", "OSMesa"))):
        raise InputError(f"no OpenGL without a screen; expected {_EXPECTED}")


MP4 = Format(
    name="mp4",
    title="a video for slides and papers, H.264",
    purpose=Purpose.LOOKING,
    suffix=".mp4",
    write=_write_mp4,
    conventions="""\
A video: H.264 in MP4, 8 bit 4:2:0, which every player and every slide program plays.

What is drawn is what the html replay shows, from a camera that does not move: robot, forces,
inertia ellipsoid, trails, ground and boxes, of a rollout also the plan as a ghost, where the file
holds it. 1 s of video is 1 s of motion: picture k is the motion at k/fps - pad. Forces of a rollout
are means from picture to picture. Camera: azimuth (0 looks from ahead, 90 from the left), elevation
[deg] and distance [m]; left out, from where the page looks, so far away that the robot is in the
picture all the time. An arrow of 0.8 m is a force as large as the robot's weight. Title and, as
"comment", JSON with request, robot and solver are in the file's metadata.

The scene is that of format mujoco, drawn by MuJoCo without a screen, by the processor where there
is no graphics card: about 0.1 s a picture of 960 x 540 on two cores, and then with smooth edges
only up to 640 x 360.
""",
    options=("fps", "pad", "size", "camera"),
    extra=Extra("video", ("av",)),
    machine=_check_machine,
)

GIF = Format(
    name="gif",
    title="a moving picture that repeats, for web pages and slides",
    purpose=Purpose.LOOKING,
    suffix=".gif",
    write=_write_gif,
    conventions="""\
A moving picture that repeats, for pages and chats that show no videos: GIF with 255 colours.

What is drawn is what the mp4 shows; its conventions describe the camera. GIF counts in 1/100 s:
pictures are shown for as many as come nearest to 1/fps without drifting, at most 50 a second. Its
comment is JSON with request, robot and solver.
""",
    options=("fps", "pad", "size", "camera"),
    defaults=Options(fps=25.0, size=(640, 360)),
    machine=_check_machine,
)
