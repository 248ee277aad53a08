"""OPT-Mimic's reference motion, from which its policies learn: rows of 14 + 3 J numbers, no header.

`t` s from 0 on; position of the root link's origin, m; its attitude as a quaternion w, x, y, z
(w first, positive in the first row, without jumps of sign); velocity of that origin, m/s, and
angular velocity, rad/s; J joint angles, rad; J joint velocities, rad/s; J joint torques, Nm. World
frame, z up. Numbers have 16 decimals and are separated by ", ". 50 rows/s unless asked otherwise:
its trainer refuses files of another rate than its own control.

Legs are FL, FR, HL, HR, joints from the base outwards, angles as in Solo's URDF. OPT-Mimic's own
files are of Solo8, J = 8, 38 columns. Robots here have 12 joints, abduction first, and 50 columns:
the blocks of its reader (8 numbers from column 14, 22 and 30 on) have to become 12 from 14, 26 and
38 on.

The torques are those that the contact forces alone ask of the joints, as OPT-Mimic has them, and
zero for a foot in the air: its trainer takes a leg to be in contact where they are not. Torques
with the legs' own weight and inertia are in the format "csv". Its planner writes angular velocity
in the body's axes and its trainer reads it in the world's; for its motions in a plane both are the
same, and here it is the trainer's. Joint velocities are the motion's own, not differences.

The JSON file beside it has the rate, the joints' names and the columns.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.errors import InputError
from llsrbm.formats.base import Format, Options
from llsrbm.formats.wire.quadruped import corner_legs
from llsrbm.motion.trajectory import Trajectory
from llsrbm.motion.whole_body import WholeBodyMotion, pinocchio_states, whole_body_motion

Array = NDArray[np.float64]

_LEGS = ("FL", "FR", "RL", "RR")
_ROOT = ["t", "x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz"]


def _write(trajectory: Trajectory, path: Path, options: Options) -> None:
    motion = whole_body_motion(trajectory, options.fps, options.pad)
    robot = motion.robot
    legs = corner_legs(robot, OPT_MIMIC_CSV.name)
    if not robot.file.foot.is_point:
        raise InputError(
            f'format "{OPT_MIMIC_CSV.name}": robot {robot.name} has soles; expected points'
        )
    names = [joint for leg in _LEGS for joint in legs[leg].joints]
    joints = [robot.joint_names.index(joint) for joint in names]
    quat = motion.base_quat if motion.base_quat[0, 0] >= 0 else -motion.base_quat
    rows = np.column_stack(
        [
            *(motion.time, motion.base_position, quat),
            *(motion.base_velocity, motion.angular_velocity),
            *(motion.joint_position[:, joints], motion.joint_velocity[:, joints]),
            contact_torques(motion)[:, joints],
        ]
    )
    np.savetxt(path, rows, fmt="%.16f", delimiter=", ")
    OPT_MIMIC_CSV.write_beside(
        path,
        trajectory,
        options,
        quaternion_order="wxyz",
        joint_order=names,
        columns=[*_ROOT, *(f"{part}/{name}" for part in ("q", "dq", "tau") for name in names)],
    )


def contact_torques(motion: WholeBodyMotion) -> Array:
    """(K, J) Nm with which joints balance the forces on point feet, as if legs weighed nothing."""
    robot, forces = motion.robot, motion.foot_force
    assert forces is not None  # plans and rollouts have them
    model, data = robot.model, robot.model.createData()
    torques = np.zeros((len(motion.time), model.nv))
    for k, q in enumerate(pinocchio_states(motion.qpos, motion.qvel)[0]):
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        for leg, force in zip(robot.legs, forces[k], strict=True):
            frame, axes = leg.foot_frame_id, pin.LOCAL_WORLD_ALIGNED
            torques[k] -= pin.getFrameJacobian(model, data, frame, axes)[:3].T @ force
    return torques[:, 6:]


OPT_MIMIC_CSV = Format(
    name="opt-mimic-csv",
    title="reference motion for OPT-Mimic: time, root, quaternion w x y z, joints, torques",
    suffix=".csv",
    write=_write,
    conventions=__doc__,
    options=("fps", "pad"),
    defaults=Options(fps=50.0),
)
