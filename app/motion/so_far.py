"""Frames of a simulation that still runs, out of the states so far: cheap enough for five a second.

Their contact forces are not known yet, and which feet stand is told from how they move.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from app.motion.frames import Frames, make_frames
from llsrbm.mechanics import sign_continuous
from llsrbm.motion.states import standing
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.robots import Robot
from llsrbm.robots.feet import foot_contacts

Array = NDArray[np.float64]


def frames_so_far(robot: Robot, time: Array, qpos: Array) -> Frames:
    """Frames at the instants of `app.workers.protocol.SimulatedSoFar`.

    Args:
        robot: that is simulated.
        time: (K,) s, one or more.
        qpos: (K, 7 + J) in MuJoCo's convention, joints in `Robot.joint_names`' order.
    """
    com, inertia, feet = _from_states(robot, qpos)
    rates = np.zeros((len(time), qpos.shape[1] - 7))
    speed = np.zeros(feet.shape[:2])
    if len(time) > 1:
        speed = np.linalg.norm(np.gradient(feet, time, axis=0), axis=-1)
    zeros = np.zeros((len(time), 3))
    return make_frames(
        WholeBodyMotion(
            robot=robot,
            origin="simulation",
            time=time,
            fps=None,
            base_position=qpos[:, :3],
            base_quat=sign_continuous(qpos[:, 3:7]),
            # Frames have no velocities.
            base_velocity=zeros,
            angular_velocity=zeros,
            joint_position=qpos[:, 7:],
            joint_velocity=rates,
            com=com,
            linear_momentum=zeros,
            angular_momentum=zeros,
            inertia=inertia,
            foot_position=feet,
            contact=standing(time, speed, feet[..., 2]),
        )
    )


def _from_states(robot: Robot, qpos: Array) -> tuple[Array, Array, Array]:
    """CoM (K, 3), inertia about it (K, 3, 3) and feet (K, L, 3) of the whole body."""
    model, data, contacts = robot.model, robot.model.createData(), foot_contacts(robot)
    q = np.concatenate([qpos[:, :3], qpos[:, 4:7], qpos[:, 3:4], qpos[:, 7:]], axis=1)
    v = np.zeros(model.nv)
    com, inertia = np.empty((len(q), 3)), np.empty((len(q), 3, 3))
    feet = np.empty((len(q), len(contacts), 3))
    middles = [contact.centres.mean(axis=0) for contact in contacts]
    for k in range(len(q)):
        pin.ccrba(model, data, q[k], v)
        com[k], inertia[k] = data.com[0], data.Ig.inertia
        for i, leg in enumerate(robot.legs):
            frame = pin.updateFramePlacement(model, data, leg.foot_frame_id)
            feet[k, i] = frame.act(middles[i])
    feet[..., 2] -= np.array([contact.radius for contact in contacts])
    return com, inertia, feet
