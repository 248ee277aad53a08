"""The two links of a leg that folds at a knee, from the URDF."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pinocchio as pin

from llsrbm.robots.robot import Robot

# Axes closer than this to parallel make hip and knee a planar pair, rad.
_PARALLEL = 0.1


@lru_cache(maxsize=16)
def knee_links(robot: Robot) -> tuple[float, float] | None:
    """Thigh and shank, m: hip joint to knee, knee to foot, seen along the knee's axis.

    None for a robot whose legs do not fold so: the joint after the hip joint of the robot file is
    not revolute about a parallel axis (a prismatic leg, for example). Mean over the legs.
    """
    model, data = robot.model, robot.model.createData()
    pin.framesForwardKinematics(model, data, robot.posture)
    links = []
    for leg, frames in zip(robot.legs, robot.file.legs.values(), strict=True):
        after_hip = leg.joints.index(frames.hip) + 1
        if after_hip >= len(leg.joints):
            return None
        hip, knee = leg.joint_ids[after_hip - 1], leg.joint_ids[after_hip]
        hip_axis, knee_axis = _axis(model, data, hip), _axis(model, data, knee)
        if hip_axis is None or knee_axis is None:
            return None
        if np.linalg.norm(np.cross(hip_axis, knee_axis)) > np.sin(_PARALLEL):
            return None
        in_plane = np.eye(3) - np.outer(knee_axis, knee_axis)
        points = [
            data.oMi[hip].translation,
            data.oMi[knee].translation,
            data.oMf[leg.foot_frame_id].translation,
        ]
        links.append([float(np.linalg.norm(in_plane @ d)) for d in np.diff(points, axis=0)])
    thigh, shank = np.mean(links, axis=0)
    return float(thigh), float(shank)


def _axis(model: pin.Model, data: pin.Data, joint: int) -> np.ndarray | None:
    """World direction of a revolute joint's axis; None for another kind of joint."""
    if not model.joints[joint].shortname().startswith("JointModelR"):
        return None
    column = model.joints[joint].idx_v
    pin.computeJointJacobians(model, data)
    angular = pin.getJointJacobian(model, data, joint, pin.LOCAL_WORLD_ALIGNED)[3:, column]
    return np.array(angular / np.linalg.norm(angular))
