"""What of a foot touches the ground: the sphere that the URDF gives it for collisions."""

from __future__ import annotations

from dataclasses import dataclass

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.errors import RobotFileError
from llsrbm.robots.robot import Leg, Robot

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FootContact:
    """A foot's sphere.

    Attributes:
        centre: (3,) m, in the frame that the robot file names as the leg's foot.
        radius: m.
    """

    centre: Array
    radius: float


def foot_contacts(robot: Robot) -> tuple[FootContact, ...]:
    """The sphere of each foot, in the order of the legs: of several the nearest to its frame.

    Raises:
        RobotFileError: the URDF gives a foot no sphere.
    """
    shapes = collision_shapes(robot)
    return tuple(_foot_contact(robot, leg, shapes) for leg in robot.legs)


def collision_shapes(robot: Robot) -> list[pin.GeometryObject]:
    """The URDF's collision geometry, placed in the frames of `robot.model`'s joints.

    Raises:
        RobotFileError: it cannot be read, for instance for a mesh that is missing.
    """
    try:
        geometry = pin.buildGeomFromUrdf(
            robot.model,
            str(robot.urdf_path),
            pin.GeometryType.COLLISION,
            package_dirs=[str(directory) for directory in robot.package_dirs],
        )
    except (ValueError, RuntimeError) as error:
        reason = " ".join(str(error).split())
        raise RobotFileError(
            f"{robot.path}: urdf: the collision geometry of {robot.urdf_path} cannot be read: "
            f"{reason}"
        ) from error
    return list(geometry.geometryObjects)


def _foot_contact(robot: Robot, leg: Leg, shapes: list[pin.GeometryObject]) -> FootContact:
    frame = robot.model.frames[leg.foot_frame_id]
    spheres = [
        FootContact(
            centre=frame.placement.actInv(shape.placement.translation),
            radius=float(shape.geometry.radius),
        )
        for shape in shapes
        if shape.parentJoint == frame.parentJoint and isinstance(shape.geometry, coal.Sphere)
    ]
    if not spheres:
        raise RobotFileError(
            f'{robot.path}: legs.{leg.name}.foot: the link that carries "{leg.foot_frame}" has no '
            f"collision sphere in {robot.urdf_path}; expected one at the foot"
        )
    return min(spheres, key=lambda sphere: float(np.linalg.norm(sphere.centre)))
