"""A robot's arms, and how the others mirror the first one."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.robots.robot import Arm
from llsrbm.robots.schema import RobotFile
from llsrbm.robots.urdf import frame_id

_SEEN = np.array([-1.0, 1.0, -1.0])  # of a turn about (x, y, z) in a mirror at the plane y = 0


def built_arms(
    file: RobotFile, model: pin.Model, joint_ids: dict[str, list[int]]
) -> tuple[Arm, ...]:
    """The arms of a robot file, by the joints of each, in the order of the file."""
    first = joint_ids[next(iter(file.arms))] if file.arms else []
    return tuple(
        Arm(
            name=name,
            hand_frame=frames.hand,
            hand_frame_id=frame_id(model, frames.hand),
            joints=tuple(model.names[j] for j in joint_ids[name]),
            joint_ids=tuple(joint_ids[name]),
            q_index=np.array([model.joints[j].idx_q for j in joint_ids[name]]),
            v_index=np.array([model.joints[j].idx_v for j in joint_ids[name]]),
            mirror=mirror_signs(model, first, joint_ids[name]),
        )
        for name, frames in file.arms.items()
    )


def mirror_signs(model: pin.Model, first: list[int], other: list[int]) -> Array:
    """(n,) of +1 or -1: by which the joint angles of an arm are those of the first one, mirrored.

    Of an arm on the first one's side, in the same way as that.
    """
    data = model.createData()
    pin.computeJointJacobians(model, data, pin.neutral(model))
    axes, others = (
        data.J[3:, [model.joints[j].idx_v for j in joints]].T for joints in (first, other)
    )
    # Shoulders may begin in the middle of the trunk.
    sides = [data.oMi[joints[-1]].translation[1] for joints in (first, other)]
    seen = axes * (_SEEN if sides[0] * sides[1] < 0 else 1.0)
    return np.where((others * seen).sum(axis=1) < 0, -1.0, 1.0)
