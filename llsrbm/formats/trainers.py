"""Reference motions as rows of numbers, as trainers and retargeters read them."""

import json
import pickle
from pathlib import Path
from typing import Any

import numpy as np

from llsrbm.arrays import Array
from llsrbm.formats.base import ORDERS, Format, Options, Purpose, Written, frames_of
from llsrbm.formats.pickled_clips import PICKLES, read_clip
from llsrbm.mechanics import rotation_matrices
from llsrbm.motion.bodies import body_motion, body_order

_PICKLE_PROTOCOL = 4  # Python 3.4 and later: simulators are tied to old ones
_XYZW = [1, 2, 3, 0]


class _Pickler(pickle.Pickler):
    """Arrays as `numpy.array(list)`: NumPy 2 names internals that NumPy 1 does not have."""

    def reducer_override(self, obj: Any) -> Any:
        return (np.array, (obj.tolist(),)) if isinstance(obj, np.ndarray) else NotImplemented


def _write_pickle(path: Path, content: dict[str, Any]) -> None:
    with path.open("wb") as file:
        _Pickler(file, protocol=_PICKLE_PROTOCOL).dump(content)


def _write_gmr(written: Written, path: Path, options: Options) -> None:
    motion = frames_of(written, options)
    bodies = body_motion(motion, ORDERS[0])
    from_root = bodies.position - motion.base_position[:, None]
    R_world_base = rotation_matrices(motion.base_quat)
    content = {
        "fps": options.fps,
        "root_pos": motion.base_position,
        "root_rot": motion.base_quat[:, _XYZW],
        "dof_pos": bodies.order.position(motion),
        "local_body_pos": np.einsum("kji,kbj->kbi", R_world_base, from_root),
        "link_body_list": list(bodies.order.bodies),
    }
    _write_pickle(path, content)
    joints = list(bodies.order.joints)
    GMR_PKL.write_beside(path, written, options, quaternion_order="xyzw", joint_order=joints)


def _write_mimickit(written: Written, path: Path, options: Options) -> None:
    motion = frames_of(written, options)
    order = body_order(motion.robot, ORDERS[0])
    root = motion.base_position, exponential_map(motion.base_quat)
    frames = np.hstack([*root, order.position(motion)])
    # Lists, as MimicKit writes them. Loop mode 0: the motion stops at its end.
    _write_pickle(path, {"loop_mode": 0, "fps": options.fps, "frames": frames.tolist()})
    columns = ["x", "y", "z", "rx", "ry", "rz", *order.joints]
    MIMICKIT_PKL.write_beside(
        path, written, options, joint_order=list(order.joints), columns=columns
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
    return quat[:, 1:] * scale[:, None]


def _write_motion_imitation(written: Written, path: Path, options: Options) -> None:
    motion = frames_of(written, options)
    order = body_order(motion.robot, ORDERS[0])
    root = motion.base_position, motion.base_quat[:, _XYZW]
    frames = np.hstack([*root, order.position(motion)])
    head = {
        "LoopMode": "Clamp",
        "FrameDuration": 1 / options.fps,
        "EnableCycleOffsetPosition": False,
        "EnableCycleOffsetRotation": False,
        "JointOrder": list(order.joints),
        "Meta": MOTION_IMITATION_JSON.described(written, options, quaternion_order="xyzw"),
    }
    lines = [f"{json.dumps(key)}: {json.dumps(head[key], allow_nan=False)},\n" for key in head]
    rows = ["[" + ", ".join(f"{value:.9f}" for value in row) + "]" for row in frames]
    path.write_text(
        "{\n" + "".join(lines) + '"Frames":\n[\n' + ",\n".join(rows) + "\n]\n}\n", encoding="utf-8"
    )


GMR_PKL = Format(
    name="gmr-pkl",
    title="motion for readers of GMR's files: root, quaternion x y z w, joints, bodies, pickled",
    purpose=Purpose.LEARNING,
    suffix=".pkl",
    write=_write_gmr,
    write_motion=_write_gmr,
    conventions="""\
GMR's motion of a robot: a pickled dictionary of arrays.

`fps`; `root_pos` (T, 3) m: origin of the root link; `root_rot` (T, 4): its attitude x, y, z, w
(w last) without jumps of sign; `dof_pos` (T, J) rad, m for joints that slide; `local_body_pos`
(T, B, 3) m: origins of the B = 1 + J bodies in the root link's frame; `link_body_list`: their
names. World frame, z up. Joints and bodies are in MuJoCo's order: limb after limb as the URDF lists
them, the root first, joints that the robot's file holds among them. 30 frames/s unless asked
otherwise, GMR's own rate.

The arrays are pickled such that NumPy 1 and 2 open them. A JSON file beside it has request, robot,
solver and the names of the joints.

Can be opened, and so can files of human2humanoid, PHC and ASAP (`root_trans_offset`, `root_rot`,
`dof`, by joblib or not, one clip in a dictionary) and of MimicKit: arrays, numbers and text alone
are read, and nothing that a pickle names is run. Joints are those of the file beside it, else told
by their number, as of "unitree-csv"; of G1 also 23 without wrists. Velocities are differences of
the frames around.
""",
    options=("fps", "pad"),
    defaults=Options(fps=30.0),
    read=read_clip,
    recognises=lambda path: path.suffix.lower() in PICKLES,
)

MIMICKIT_PKL = Format(
    name="mimickit-pkl",
    title="motion reference for MimicKit: root, exponential map and joints, pickled",
    purpose=Purpose.LEARNING,
    suffix=".pkl",
    write=_write_mimickit,
    write_motion=_write_mimickit,
    conventions="""\
MimicKit's motion: a pickled dictionary.

`loop_mode`: 0, the motion stops at its end; `fps`; `frames`: T lists of 3 + 3 + J numbers: position
of the root link's origin, m; its attitude as an exponential map (axis times angle, rad); joints,
rad. World frame, z up. Joints are limb after limb as the URDF lists them, held ones among them: the
depth-first order that MimicKit has of a character's MJCF or URDF. 60 frames/s unless asked
otherwise; MimicKit takes velocities as differences of frames.

The exponential map goes on past 180 deg, up to 360, instead of jumping to the opposite axis:
MimicKit makes a quaternion of each frame, which is the same either way, and tools that interpolate
the numbers themselves see no jump. A character of MimicKit has no joints that slide; their columns
are in m. A JSON file beside it has request, robot, solver and the names of the columns. Can be
opened, like "gmr-pkl".
""",
    options=("fps", "pad"),
    read=read_clip,
)

MOTION_IMITATION_JSON = Format(
    name="motion-imitation-json",
    title="motion clip of motion_imitation: rows of root, quaternion x y z w and joints",
    purpose=Purpose.LEARNING,
    suffix=".json",
    write=_write_motion_imitation,
    write_motion=_write_motion_imitation,
    conventions="""\
The motion clip of motion_imitation, from which quadrupeds learned to imitate dogs: JSON.

`LoopMode` "Clamp": the motion stops at its end; `FrameDuration` s; `EnableCycleOffsetPosition` and
`EnableCycleOffsetRotation` false; `Frames`: rows of 3 + 4 + J numbers: position of the root link's
origin, m; its attitude as a quaternion x, y, z, w (w last) without jumps of sign; joints, rad, m
for joints that slide. World frame, z up. Nine decimals. 60 frames/s unless asked otherwise, as the
clips that come with it. Its loader moves the motion to begin above the origin, makes w positive and
takes velocities as differences of frames.

Joints are limb after limb as the URDF lists them, held ones among them, PyBullet's order;
`JointOrder` names them. The
loader reads the keys that it knows, so `Meta` has everything else beside the numbers.
""",
    options=("fps", "pad"),
)
