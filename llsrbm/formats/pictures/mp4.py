"""A video: H.264 in MP4, 8 bit 4:2:0, which every player and every slide program plays.

What is drawn is what the html replay shows, from a camera that does not move: robot, forces,
inertia ellipsoid, trails, ground and boxes, of a rollout also the plan as a ghost, where the file
holds it. 1 s of video is 1 s of motion: picture k is the motion at k/fps - pad. Forces of a rollout
are means from picture to picture. Camera: azimuth (0 looks from ahead, 90 from the left), elevation
[deg] and distance [m]; left out, from where the page looks, so far away that the robot is in the
picture all the time. Title and, as "comment", JSON with request, robot and solver are in the file's
metadata.

Drawn by MuJoCo without a screen, by the processor where there is no graphics card: about 0.1 s a
picture of 960 x 540 on two cores, and then with smooth edges only up to 640 x 360.
"""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import numpy as np

from llsrbm.errors import InputError
from llsrbm.formats.base import Extra, Format, Options
from llsrbm.formats.pictures.drawing import title
from llsrbm.formats.pictures.film import pictures
from llsrbm.formats.sidecar import described
from llsrbm.motion.trajectory import Trajectory

FASTEST = 240.0  # pictures/s; players refuse more
_QUALITY = "18"  # x264's constant rate factor: hardly to be told from what was drawn
_FINEST = 10_000  # denominator of a rate


def write_mp4(trajectory: Trajectory, path: Path, options: Options) -> None:
    """Write the video."""
    import av
    from av.video.reformatter import ColorRange, Colorspace

    if any(n % 2 for n in options.size):
        raise InputError(
            f"size: expected even numbers for a video, got {options.size[0]}x{options.size[1]}"
        )
    if not 1 <= options.fps <= FASTEST:
        raise InputError(f"fps: expected 1 to {FASTEST:g} for a video, got {options.fps:g}")
    rate = Fraction(options.fps).limit_denominator(_FINEST)
    # The index before the pictures, so that a video on a web page begins at once.
    flags = {"movflags": "faststart"}
    with av.open(str(path), "w", format="mp4", options=flags) as container:
        container.metadata["title"] = title(trajectory)
        container.metadata["comment"] = json.dumps(
            described(trajectory, MP4.name, fps=options.fps, pad=options.pad), allow_nan=False
        )
        stream = container.add_stream("libx264", rate=rate, options={"crf": _QUALITY})
        stream.width, stream.height = options.size
        stream.pix_fmt = "yuv420p"
        # Named, or players guess by the picture's size, and reds change with it.
        stream.codec_context.colorspace = Colorspace.ITU709
        stream.codec_context.color_range = ColorRange.MPEG
        for picture in pictures(trajectory, options):
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")
            coded = frame.reformat(
                format="yuv420p",
                dst_colorspace=Colorspace.ITU709,
                dst_color_range=ColorRange.MPEG,
            )
            container.mux(stream.encode(coded))
        container.mux(stream.encode(None))


MP4 = Format(
    name="mp4",
    title="a video, H.264",
    suffix=".mp4",
    write=write_mp4,
    conventions=__doc__,
    options=("fps", "pad", "size", "camera"),
    defaults=Options(fps=60.0),
    extra=Extra("video", ("av",)),
)
