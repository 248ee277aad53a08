"""The robot's trunk and knees: what of it, beside its feet, must not run into anything."""

from functools import lru_cache

import numpy as np

from llsrbm.arrays import Array
from llsrbm.errors import RobotFileError
from llsrbm.robots.feet import collision_shapes
from llsrbm.robots.robot import Robot
from llsrbm.robots.urdf import BASE_JOINT

# A joint so far from hip and foot, as a share of their distance in the default posture, is a knee.
# Abduction joints are nearer to the hip, ankles to the foot, and what slides bends nothing.
_KNEE = 0.2


@lru_cache(maxsize=16)
def trunk_box(robot: Robot) -> Array:
    """(2, 3) m: lowest and highest corner of the root link's collision geometry, base axes. Raises
    `RobotFileError`: it has none.
    """
    points = [shape.corners for shape in collision_shapes(robot) if shape.joint == BASE_JOINT]
    if not points:
        raise RobotFileError(
            f"{robot.path}: urdf: the base of {robot.urdf_path} has no collision geometry; "
            "expected some, or nothing tells what the trunk would run into"
        )
    every = np.concatenate(points)
    return np.array([every.min(axis=0), every.max(axis=0)])


@lru_cache(maxsize=16)
def knee_joint(robot: Robot) -> int | None:
    """Index of a leg's knee among its joints, counted from the base outwards; None: it has none."""
    angles = robot.posture[7:][robot.leg_joint_index]
    hip, foot = robot.hips[0], robot.chains.motion(angles).foot[0]
    origin = robot.chains.origins(angles)[0]
    ends = np.array([hip, foot])[:, None]
    near = np.linalg.norm(origin - ends, axis=-1).min(axis=0)
    near[robot.chains.prismatic] = 0.0
    knee = int(near.argmax())
    return knee if near[knee] > _KNEE * float(np.linalg.norm(foot - hip)) else None
