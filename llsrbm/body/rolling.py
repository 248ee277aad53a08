"""Ball feet roll: where standing feet go while their shanks turn.

The middle of a ball of radius r that rolls without slipping moves with r omega x e_z, and its
contact point, right below, with it: 17 mm in a back flip's take-off, which is 14 % of its angular
momentum.
"""

import numpy as np

from llsrbm.arrays import Array, IntArray
from llsrbm.mechanics import apply, rotation_matrices, rotation_vectors
from llsrbm.request.schedule import Schedule
from llsrbm.robots.feet import foot_contacts
from llsrbm.robots.robot import Robot


def rolled(
    robot: Robot,
    joint_position: Array,
    base_quat: Array,
    schedule: Schedule,
    phase: IntArray,
    *,
    frames: bool = False,
) -> Array:
    """(K, L, 2) m: how far standing feet are from where they stand, horizontally, world frame.

    They stand there when it all begins, when they have just landed, and when it all ends; feet that
    swing stay where they left. Soles do not roll.

    Args:
        robot: the robot.
        joint_position: (K, J) rad at knots; base_quat: (K, 4) w, x, y, z.
        schedule: which feet stand in which phase; phase: (K,) of the interval after each knot.
        frames: of the feet's frames, which turn about the middles of their balls.
    """
    stands = schedule.stands[phase]
    away = np.zeros((*stands.shape, 2))
    if not robot.file.foot.is_point:
        return away
    angles = joint_position[:, robot.leg_joint_index]
    in_base = robot.chains.motion(angles, rotations=True, joints=joint_position).foot_rotation
    assert in_base is not None
    R_world_foot = rotation_matrices(base_quat)[:, None] @ in_base
    turn = R_world_foot[1:] @ np.swapaxes(R_world_foot[:-1], -1, -2)
    vector = rotation_vectors(turn)
    contacts = foot_contacts(robot)
    radius = np.array([contact.radius for contact in contacts])[:, None]
    step = radius * np.stack([vector[..., 1], -vector[..., 0]], axis=-1)
    if frames:
        middle = np.array([contact.centres[0] for contact in contacts])
        step -= np.diff(apply(R_world_foot, middle), axis=0)[..., :2]
    for k in range(1, len(away)):
        landed = ~stands[k - 1] & stands[k]
        stood = stands[k - 1][:, None]
        away[k] = np.where(landed[:, None], 0.0, away[k - 1] + stood * step[k - 1])
    for leg in range(stands.shape[1]):  # the last place is where it stands at rest
        swings = np.flatnonzero(~stands[:, leg])
        if len(swings):
            away[swings[-1] + 1 :, leg] -= away[-1, leg]
    return away
