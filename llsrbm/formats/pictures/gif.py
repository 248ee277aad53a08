"""A moving picture that repeats, for pages and chats that show no videos: GIF with 255 colours.

What is drawn is what the mp4 shows; its docstring tells of the camera. GIF counts in 1/100 s:
pictures are shown for as many as come nearest to 1/fps without drifting, at most 50 a second. Its
comment is JSON with request, robot and solver.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from llsrbm.errors import InputError
from llsrbm.formats.base import Format, Options
from llsrbm.formats.pictures.film import Picture, pictures
from llsrbm.formats.sidecar import described
from llsrbm.look import palette
from llsrbm.motion.trajectory import Trajectory

FASTEST = 50.0  # pictures/s; browsers slow down what is faster
_COLOURS = 255
_LOOKED_AT = 6  # pictures that the colours are taken from
_ROUNDED = 4  # of 256 shades: shading that nobody sees would take most of the file


def write_gif(trajectory: Trajectory, path: Path, options: Options) -> None:
    """Write the picture."""
    from PIL import Image

    if not 1 <= options.fps <= FASTEST:
        raise InputError(f"fps: expected 1 to {FASTEST:g} for a gif, got {options.fps:g}")
    drawn = list(pictures(trajectory, options))
    chosen = [drawn[k] for k in np.linspace(0, len(drawn) - 1, _LOOKED_AT).round().astype(int)]
    seen = np.vstack([_rounded(picture) for picture in [*chosen, _swatches(options.size)]])
    colours = Image.fromarray(seen).quantize(_COLOURS, Image.Quantize.MEDIANCUT)
    # One table of colours for all, and no dither: what does not move stays as it is.
    frames = [
        Image.fromarray(_rounded(picture)).quantize(palette=colours, dither=Image.Dither.NONE)
        for picture in drawn
    ]
    comment = json.dumps(
        described(trajectory, GIF.name, fps=options.fps, pad=options.pad), allow_nan=False
    )
    frames[0].save(
        path,
        format="GIF",
        save_all=True,
        append_images=frames[1:],
        duration=durations(len(frames), options.fps),
        loop=0,
        comment=comment.encode(),
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


GIF = Format(
    name="gif",
    title="a moving picture that repeats",
    suffix=".gif",
    write=write_gif,
    conventions=__doc__,
    options=("fps", "pad", "size", "camera"),
    defaults=Options(fps=25.0, size=(640, 360)),
)
