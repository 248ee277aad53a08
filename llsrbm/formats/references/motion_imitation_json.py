"""The motion clip of motion_imitation, from which quadrupeds learned to imitate dogs: JSON.

`LoopMode` "Clamp": the motion stops at its end; `FrameDuration` s; `EnableCycleOffsetPosition` and
`EnableCycleOffsetRotation` false; `Frames`: rows of 3 + 4 + J numbers: position of the root link's
origin, m; its attitude as a quaternion x, y, z, w (w last) without jumps of sign; joints, rad, m
for joints that slide. World frame, z up. Nine decimals. 60 frames/s unless asked otherwise, as the
clips that come with it. Its loader moves the motion to begin above the origin, makes w positive and
takes velocities as differences of frames.

Joints are leg after leg as the URDF lists them, PyBullet's order; `JointOrder` names them. The
loader reads the keys that it knows, so `Meta` has everything else beside the numbers.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from llsrbm.formats.base import ORDERS, Format, Options
from llsrbm.formats.sidecar import described
from llsrbm.motion.bodies import body_order
from llsrbm.motion.trajectory import Trajectory
from llsrbm.motion.whole_body import whole_body_motion


def write_motion_imitation(trajectory: Trajectory, path: Path, options: Options) -> None:
    """Write the clip, a line a frame."""
    motion = whole_body_motion(trajectory, options.fps, options.pad)
    order = body_order(motion.robot, ORDERS[0])
    frames = np.hstack(
        [
            motion.base_position,
            motion.base_quat[:, [1, 2, 3, 0]],
            motion.joint_position[:, list(order.joint_index)],
        ]
    )
    head = {
        "LoopMode": "Clamp",
        "FrameDuration": 1 / options.fps,
        "EnableCycleOffsetPosition": False,
        "EnableCycleOffsetRotation": False,
        "JointOrder": list(order.joints),
        "Meta": described(
            trajectory,
            MOTION_IMITATION_JSON.name,
            fps=options.fps,
            pad=options.pad,
            quaternion_order="xyzw",
        ),
    }
    lines = [f"{json.dumps(key)}: {json.dumps(head[key], allow_nan=False)},\n" for key in head]
    rows = ["[" + ", ".join(f"{value:.9f}" for value in row) + "]" for row in frames]
    path.write_text(
        "{\n" + "".join(lines) + '"Frames":\n[\n' + ",\n".join(rows) + "\n]\n}\n", encoding="utf-8"
    )


MOTION_IMITATION_JSON = Format(
    name="motion-imitation-json",
    title="motion clip of motion_imitation: rows of root, quaternion x y z w and joints",
    suffix=".json",
    write=write_motion_imitation,
    conventions=__doc__,
    options=("fps", "pad"),
)
