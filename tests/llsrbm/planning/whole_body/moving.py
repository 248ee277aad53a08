"""A robot in motion, as tests of the whole-body problem's expressions need it."""

import numpy as np

from llsrbm.mechanics import rotation_matrices


def moving(robot, seed):
    """A random posture and its rates, as a state and in Pinocchio's convention."""
    rng = np.random.default_rng(seed)
    quat = rng.normal(size=4)
    quat /= np.linalg.norm(quat)
    joints = robot.posture[7:] + 0.3 * rng.normal(size=robot.model.nv - 6)
    state = {
        "position": rng.normal(size=3),
        "quat": quat,
        "joint_position": joints,
        "velocity": rng.normal(size=3),
        "omega": rng.normal(size=3),
        "joint_velocity": rng.normal(size=len(joints)),
    }
    q = np.concatenate([state["position"], quat[[1, 2, 3, 0]], joints])
    in_base = rotation_matrices(quat).T @ state["velocity"]
    return state, q, np.concatenate([in_base, state["omega"], state["joint_velocity"]])
