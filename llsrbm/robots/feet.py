"""Feet: the spheres that touch the ground, one at each contact point, and soles that stand."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial import ConvexHull

from llsrbm.arrays import Array
from llsrbm.errors import RobotFileError
from llsrbm.robots.robot import Leg, Robot
from llsrbm.robots.solids import PlacedSolid, placed_solids

_LEVEL = 0.01  # rad by which soles may lean: joint angles in a file are rounded


@dataclass(frozen=True, eq=False)
class FootContact:
    """A foot's spheres, all alike, of a radius (m) at c contact points.

    `centres`: (c, 3) m, in the frame that the robot file names as the leg's foot, in the order of
    the file's corners. `above`: (c, 3) m in that frame, what is by `lift` m above the points where
    the ground pushes: a ball's middle, or a sole's corners themselves.
    """

    centres: Array
    radius: float
    above: Array
    lift: float

    @property
    def middle(self) -> Array:
        """(3,) m in that frame: the centre of a point foot's ball; of a sole what is above its
        frame, the foot's place in plans, as high as the centres, which may lie further ahead.
        """
        middle: Array = self.centres.mean(axis=0)
        return middle if len(self.centres) == 1 else middle * [0.0, 0.0, 1.0]


@lru_cache(maxsize=16)
def foot_contacts(robot: Robot) -> tuple[FootContact, ...]:
    """The spheres of each foot, in the order of the legs.

    They are the URDF's collision spheres nearest to the robot file's corners; where it has none,
    spheres of the file's radius: about the frame of a point foot, resting on a sole. Raises
    `RobotFileError`: the URDF gives a foot no spheres and the file no radius.
    """
    shapes = collision_shapes(robot)
    return tuple(_foot_contact(robot, leg, shapes) for leg in robot.legs)


def collision_shapes(robot: Robot) -> list[PlacedSolid]:
    """The URDF's collision geometry, placed in the frames of `robot.model`'s joints."""
    return placed_solids(robot.urdf, robot.model, "collisions")


def _foot_contact(robot: Robot, leg: Leg, shapes: list[PlacedSolid]) -> FootContact:
    frame = robot.model.frames[leg.foot_frame_id]
    spheres = [
        (frame.placement.actInv(shape.placement.translation), shape.solid.size[0])
        for shape in shapes
        if shape.joint == frame.parentJoint and shape.is_sphere
    ]
    radius = robot.file.foot.radius
    if spheres:
        nearest = [
            min(spheres, key=lambda sphere: float(np.linalg.norm(sphere[0] - corner)))
            for corner in robot.corners
        ]
        return _contact(robot, np.array([centre for centre, _ in nearest]), nearest[0][1])
    if radius is None:
        raise RobotFileError(
            f'{robot.path}: legs.{leg.name}.foot: the link that carries "{leg.foot_frame}" has no '
            f"collision sphere in {robot.urdf_path}; expected one there, or foot.radius here"
        )
    # A point foot's frame is the middle of its ball; a sole's is on the ground.
    height = 0.0 if robot.file.foot.is_point else radius
    return _contact(robot, robot.corners + np.array([0.0, 0.0, height]), radius)


def _contact(robot: Robot, centres: Array, radius: float) -> FootContact:
    if robot.file.foot.is_point:
        return FootContact(centres, radius, above=centres, lift=radius)
    return FootContact(centres, radius, above=robot.corners, lift=0.0)


def pushed_points(robot: Robot, placed: tuple[Array, Array], normals: Array | None = None) -> Array:
    """(K, L, c, 3) m, world: where the ground pushes at the feet that touch it.

    Args:
        robot: that moves.
        placed: of `placements`, K postures.
        normals: (K, L, 3) unit, of what each foot stands on; None: it is level.
    """
    turn, origin = placed
    up = np.array([0.0, 0.0, 1.0]) if normals is None else normals[:, :, None]
    points = np.empty((len(origin), len(robot.legs), len(robot.corners), 3))
    for i, (leg, contact) in enumerate(zip(robot.legs, foot_contacts(robot), strict=True)):
        frame = robot.model.frames[leg.foot_frame_id]
        joint, in_foot = frame.parentJoint, frame.placement
        above = in_foot.translation + contact.above @ in_foot.rotation.T
        points[:, i] = origin[:, joint, None] + above @ np.swapaxes(turn[:, joint], -1, -2)
    pushed: Array = points - foot_contacts(robot)[0].lift * up
    return pushed


def foot_lift(robot: Robot) -> float:
    """Height (m) of point feet's frames above the lowest points of their balls, standing. Raises
    `RobotFileError`: as `foot_contacts`.
    """
    lifts = [
        contact.radius - float((rotation @ contact.centres[0])[2])
        for contact, rotation in zip(foot_contacts(robot), robot.foot_rotation, strict=True)
    ]
    return float(np.mean(lifts))


def check_soles(robot: Robot) -> None:
    """Raise `RobotFileError` unless the default posture stands on its soles, level and balanced."""
    rotation = robot.foot_rotation
    for leg, upward in zip(robot.legs, rotation[..., 2], strict=True):
        lean = np.arctan2(np.hypot(upward[0], upward[1]), upward[2])
        if lean > _LEVEL:
            raise RobotFileError(
                f"{robot.path}: posture.{leg.name}: the sole {leg.foot_frame} leans by "
                f"{lean:.3f} rad; expected it level within {_LEVEL} rad"
            )
    points = robot.feet[:, None] + robot.corners @ np.swapaxes(rotation, -1, -2)
    edges = ConvexHull(points.reshape(-1, 3)[:, :2]).equations
    outside = edges[:, 2].max()  # of the origin, which is below the CoM
    if outside > 0:
        x, y, _ = points.mean(axis=(0, 1))
        raise RobotFileError(
            f"{robot.path}: posture: the robot tips over, its CoM is {outside:.3f} m outside what "
            f"its soles span, their middle {x:+.3f} m forward and {y:+.3f} m left of it; "
            "expected the CoM above them"
        )
