"""The motion-tracking npz of mjlab and of BeyondMimic: joints and bodies, with velocities.

`fps` (1,); `joint_pos`, `joint_vel` (T, J) rad, rad/s, m and m/s of joints that slide; `body_pos_w`
(T, B, 3) m and `body_quat_w` (T, B, 4) w, x, y, z without jumps of sign, of the links' origins;
`body_lin_vel_w`, `body_ang_vel_w` (T, B, 3) m/s and rad/s. World frame and axes, z up. Velocities
are the motion's own and not differences: lift-off and touchdown are sharp. 50 frames/s unless asked
otherwise, the rate of both families' policies.

The B = 1 + J bodies are the root link and the links that joints move, with what is welded to them,
called as in the URDF; that is what MuJoCo makes of a URDF, and Isaac Lab where it merges fixed
joints, as by default. Joints are all of the URDF's, of G1 29; those that the robot's file holds are
at rest. Both loaders take bodies by their place and not by their names, so the order
must be the reader's:

depth-first (mjlab): bodies and joints leg after leg as the URDF lists them, MuJoCo's order;
`body_lin_vel_w` is of the link's origin.

breadth-first (BeyondMimic): bodies and joints level after level, siblings by the names of their
joints, Isaac Lab's order; `body_lin_vel_w` is of the body's centre of mass, as Isaac Lab has it.

Also in the file, where the loaders do not look: `joint_names`, `body_names`, `order`, and at `meta`
everything beside the numbers as JSON.

Can be opened if it has `joint_names`: the root is the first body; momenta and inertia follow from
the states, and which feet stand is told from how they move.
"""

from pathlib import Path

import numpy as np

from llsrbm.errors import FileFormatError
from llsrbm.files.npz import Arrays, checked, keys, read_archive, text, write_archive
from llsrbm.files.quantity import BODY, JOINT, TIME, WXYZ, XYZ, Kind, Quantity
from llsrbm.formats.base import ORDERS, Format, Options, Purpose, Written, frames_of
from llsrbm.formats.foreign import (
    MOST_FRAMES,
    checked_motion,
    checked_rate,
    joint_columns,
    one_rate,
)
from llsrbm.mechanics import rotation_matrices
from llsrbm.motion.bodies import body_motion, body_order, root_com
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.robots import Robot

_BREADTH_FIRST = ORDERS[1]
_LAYOUT = {
    "joint_pos": Quantity((TIME, JOINT), "rad", "joints"),
    "joint_vel": Quantity((TIME, JOINT), "rad/s", "their velocities"),
    "joint_names": Quantity((JOINT,), "", "their names", kind=Kind.TEXT),
    "body_pos_w": Quantity((TIME, BODY, XYZ), "m", "origins of links", frame="world"),
    "body_quat_w": Quantity((TIME, BODY, WXYZ), "", "attitudes of links", frame="world"),
    "body_lin_vel_w": Quantity((TIME, BODY, XYZ), "m/s", "velocities of bodies", frame="world"),
    "body_ang_vel_w": Quantity((TIME, BODY, XYZ), "rad/s", "their turning", frame="world"),
}
_EXPECTED = "expected a motion-tracking npz file (mjlab, BeyondMimic)"


def _write(written: Written, path: Path, options: Options) -> None:
    motion = frames_of(written, options)
    bodies = body_motion(motion, options.order)
    of_com = options.order == _BREADTH_FIRST
    meta = MOTION_NPZ.described_json(
        written,
        options,
        quaternion_order="wxyz",
        linear_velocity_of="centre of mass of the body" if of_com else "origin of the link",
    )
    arrays = {
        "fps": np.array([options.fps]),
        "joint_pos": bodies.order.position(motion),
        "joint_vel": bodies.order.velocity(motion),
        "body_pos_w": bodies.position,
        "body_quat_w": bodies.quat,
        "body_lin_vel_w": bodies.com_velocity if of_com else bodies.velocity,
        "body_ang_vel_w": bodies.angular_velocity,
        "joint_names": np.array(bodies.order.joints),
        "body_names": np.array(bodies.order.bodies),
        "order": np.array(options.order),
        "meta": np.array(meta),
    }
    write_archive(path, arrays)


def _read(path: Path, robot: Robot, fps: float | None) -> WholeBodyMotion:
    arrays = read_archive(path, only={*_LAYOUT, "order", "fps"}, expected=_EXPECTED)
    if "joint_names" not in arrays:
        raise FileFormatError(
            f'{path}: key "joint_names" is missing, and the order of the joints is not known '
            "without; expected an array of their names in the file (mjlab: MuJoCo's order, "
            "BeyondMimic: Isaac Lab's)"
        )
    values = checked(arrays, _LAYOUT, path, MOST_FRAMES)
    names = [str(name) for name in values["joint_names"]]
    columns, found = joint_columns(names, values["joint_pos"], robot, f'{path}: key "joint_names"')
    quat = values["body_quat_w"][:, 0]
    R_world_base = rotation_matrices(quat / np.linalg.norm(quat, axis=1, keepdims=True))
    angular_velocity = np.einsum("kji,kj->ki", R_world_base, values["body_ang_vel_w"][:, 0])
    velocity = values["body_lin_vel_w"][:, 0]
    if _order(arrays, names, robot, path) == _BREADTH_FIRST:
        # A file without the held joints is of bodies that have what is held welded to them.
        whole = len(names) > len(robot.joint_names)
        lever = root_com(robot) if whole else robot.base.lever
        arm = np.cross(angular_velocity, lever)
        velocity = velocity - np.einsum("kij,kj->ki", R_world_base, arm)
    qpos = np.hstack([values["body_pos_w"][:, 0], quat, values["joint_pos"][:, columns]])
    qvel = np.hstack([velocity, angular_velocity, values["joint_vel"][:, columns]])
    stated = checked_rate(arrays["fps"], f'{path}: key "fps"') if "fps" in arrays else None
    requested = None if fps is None else checked_rate(fps, f"{path}: fps")
    rate, remarks = one_rate(stated, requested)
    if rate is None:
        raise FileFormatError(f'{path}: key "fps" is missing; expected frames per second')
    found = (*remarks, *found)
    return checked_motion(robot, MOTION_NPZ.name, str(path), rate, qpos, qvel, remarks=found)


def _order(arrays: Arrays, names: list[str], robot: Robot, path: Path) -> str:
    """As the file says it; else as its joints have it."""
    if "order" in arrays:
        order = text(arrays, "order", path)
        if order not in ORDERS:
            raise FileFormatError(
                f'{path}: key "order": expected {" or ".join(ORDERS)}, got {order!r:.40}'
            )
        return order
    for order in ORDERS:
        if tuple(names) == body_order(robot, order).joints:
            return order
    raise FileFormatError(
        f'{path}: key "order" is missing, and the joints are neither depth-first nor '
        "breadth-first: which point of a body the velocities are of is not known; expected "
        f"{' or '.join(ORDERS)}"
    )


MOTION_NPZ = Format(
    name="motion-npz",
    title="motion reference for mjlab or BeyondMimic: joints and bodies with exact velocities",
    purpose=Purpose.LEARNING,
    suffix=".npz",
    write=_write,
    write_motion=_write,
    conventions=__doc__,
    options=("fps", "pad", "order"),
    defaults=Options(fps=50.0),
    read=_read,
    recognises=lambda path: {"joint_pos", "body_pos_w"} <= keys(path),
)
