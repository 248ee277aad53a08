"""Kinematics and dynamics by Pinocchio alone, a posture at a time."""

import numpy as np
import pinocchio as pin


def foot_positions(robot, base_position, base_quat, joint_position):
    """(K, L, 3) m, from the URDF and the names of the foot frames in the robot file.

    Of balls what is `foot_lift` below their frames.
    """
    model = pin.buildModelFromXML(robot.urdf.skeleton, pin.JointModelFreeFlyer())
    data = model.createData()
    frames = [model.getFrameId(leg.foot_frame) for leg in robot.legs]
    feet = np.empty((len(base_position), len(frames), 3))
    for k, (p, q, angles) in enumerate(zip(base_position, base_quat, joint_position, strict=True)):
        pin.framesForwardKinematics(model, data, np.concatenate([p, np.roll(q, -1), angles]))
        feet[k] = [data.oMf[frame].translation for frame in frames]
    return feet - [0, 0, robot.foot_lift]


def link_poses(robot, qpos):
    """Link -> (3,) m and (3, 3) of the joint that moves it, for one posture in MuJoCo's order."""
    model = pin.buildModelFromXML(robot.urdf.skeleton, pin.JointModelFreeFlyer())
    data = model.createData()
    order = [robot.joint_names.index(name) for name in list(model.names)[2:]]
    q = np.concatenate([qpos[:3], np.roll(qpos[3:7], -1), qpos[7:][order]])
    pin.forwardKinematics(model, data, q)
    bodies = (frame for frame in model.frames if frame.type == pin.FrameType.BODY)
    return {
        frame.name: (data.oMi[frame.parentJoint].translation, data.oMi[frame.parentJoint].rotation)
        for frame in bodies
    }


def links_alone(robot):
    """Pinocchio's model without rotors."""
    model = robot.model.copy()
    model.armature[:] = 0.0
    return model


def of_drives(robot, dq, ddq):
    """Nm or N of rotors, damping, and friction that turns about within 3 % of the speed limit."""
    turned = dq / np.hypot(dq, 0.03 * robot.speed_limit)
    return robot.armature * ddq + robot.friction * turned + robot.damping * dq
