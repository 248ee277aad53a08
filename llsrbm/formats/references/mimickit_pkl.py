"""MimicKit's motion: a pickled dictionary.

`loop_mode`: 0, the motion stops at its end; `fps`; `frames`: T lists of 3 + 3 + J numbers: position
of the root link's origin, m; its attitude as an exponential map (axis times angle, rad); joints,
rad. World frame, z up. Joints are leg after leg as the URDF lists them: the depth-first order that
MimicKit has of a character's MJCF or URDF. 60 frames/s unless asked otherwise; MimicKit takes
velocities as differences of frames.

The exponential map goes on past 180 deg, up to 360, instead of jumping to the opposite axis:
MimicKit makes a quaternion of each frame, which is the same either way, and tools that interpolate
the numbers themselves see no jump. A character of MimicKit has no joints that slide; their columns
are in m. A JSON file beside it has request, robot, solver and the names of the columns. Files like
this one are not opened here: a pickle can run anything.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from llsrbm.formats.base import ORDERS, Format, Options
from llsrbm.formats.references.plain_pickle import write_pickle
from llsrbm.formats.sidecar import write_sidecar
from llsrbm.motion.bodies import body_order
from llsrbm.motion.trajectory import Trajectory
from llsrbm.motion.whole_body import whole_body_motion

Array = NDArray[np.float64]

_CLAMP = 0
_ROOT = ("x", "y", "z", "rx", "ry", "rz")


def write_mimickit(trajectory: Trajectory, path: Path, options: Options) -> None:
    """Write the dictionary, and what it does not say beside it."""
    motion = whole_body_motion(trajectory, options.fps, options.pad)
    order = body_order(motion.robot, ORDERS[0])
    frames = np.hstack(
        [
            motion.base_position,
            exponential_map(motion.base_quat),
            motion.joint_position[:, list(order.joint_index)],
        ]
    )
    # Lists, as MimicKit writes them.
    write_pickle(path, {"loop_mode": _CLAMP, "fps": options.fps, "frames": frames.tolist()})
    write_sidecar(
        path,
        trajectory,
        MIMICKIT_PKL.name,
        fps=options.fps,
        pad=options.pad,
        joint_order=list(order.joints),
        columns=[*_ROOT, *order.joints],
    )


def exponential_map(quat: Array) -> Array:
    """(K, 3) rad of attitudes (K, 4) w, x, y, z without jumps of sign, without jumps either.

    Angles are up to 180 deg at first and go on to 360.
    """
    quat = quat if quat[0, 0] >= 0 else -quat
    sine = np.linalg.norm(quat[:, 1:], axis=1)
    angle = 2 * np.arctan2(sine, quat[:, 0])
    tiny = sine < 1e-12
    scale = np.where(tiny, 2.0, angle / np.where(tiny, 1.0, sine))
    rotation: Array = quat[:, 1:] * scale[:, None]
    return rotation


MIMICKIT_PKL = Format(
    name="mimickit-pkl",
    title="motion reference for MimicKit: root, exponential map and joints, pickled",
    suffix=".pkl",
    write=write_mimickit,
    conventions=__doc__,
    options=("fps", "pad"),
)
