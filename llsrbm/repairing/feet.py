"""The feet of postures as the planner has them: a foot's frame, or the place below it.

The contact points of a motion (`WholeBodyMotion.foot_position`) are elsewhere: a ball touches the
ground beside what is below its leg's frame.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.mechanics import quaternions
from llsrbm.motion.whole_body import pinocchio_states
from llsrbm.robots.robot import Robot


def feet_of(robot: Robot, qpos: Array) -> tuple[Array, Array]:
    """Feet of postures (K, 7 + J), MuJoCo's convention: (K, L, 3) m and (K, L, 4) w, x, y, z.

    In the frame of the postures, as plans, footholds and `solve_postures` have them.
    """
    model, data = robot.model, robot.model.createData()
    q, _ = pinocchio_states(qpos, np.zeros((len(qpos), qpos.shape[1] - 1)))
    places = np.empty((len(q), len(robot.legs), 3))
    turns = np.empty((len(q), len(robot.legs), 3, 3))
    for k in range(len(q)):
        pin.framesForwardKinematics(model, data, q[k])
        for i, leg in enumerate(robot.legs):
            frame = data.oMf[leg.foot_frame_id]
            places[k, i], turns[k, i] = frame.translation, frame.rotation
    return places - [0.0, 0.0, robot.foot_lift], quaternions(turns)
