"""Forward kinematics by Pinocchio alone, a posture at a time."""

from __future__ import annotations

import numpy as np
import pinocchio as pin


def foot_positions(robot, base_position, base_quat, joint_position):
    """(K, L, 3) m, from the URDF and the names of the foot frames in the robot file."""
    model = pin.buildModelFromUrdf(str(robot.urdf_path), pin.JointModelFreeFlyer())
    data = model.createData()
    frames = [model.getFrameId(leg.foot_frame) for leg in robot.legs]
    feet = np.empty((len(base_position), len(frames), 3))
    for k, (p, q, angles) in enumerate(zip(base_position, base_quat, joint_position, strict=True)):
        pin.framesForwardKinematics(model, data, np.concatenate([p, np.roll(q, -1), angles]))
        feet[k] = [data.oMf[frame].translation for frame in frames]
    return feet
