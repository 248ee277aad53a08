"""Parts of feet that touch the ground: soles and their middles, points, balls."""

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.errors import RobotFileError
from llsrbm.robots.schema import AddedFrame
from llsrbm.robots.solids import PlacedSolid
from llsrbm.robots.urdf import frame_id

_CORNERS = 4  # of a sole
_OFF_THE_MIDDLE = 0.01  # m from a sole's frame to the middle of the sole on the ground
_TURNED = 1e-3  # rad, likewise
_UPRIGHT = 0.5  # rad by which a frame that may be a sole's is turned with all joints at zero
_EVEN = 2e-3  # m from a sole's lowest point within which the ground touches it
BALL = 0.02  # m, radius of a foot's ball where nothing tells


def middle_of_sole(
    model: pin.Model, data: pin.Data, foot: str, shapes: list[PlacedSolid], where: str
) -> AddedFrame | None:
    """Where the frame of a sole belongs, seen from the link at the end of its leg; None: there.

    With all joints at zero soles are level and point forward, unless the shapes lie flat on the
    ground in the frame that the URDF has there, and not so.
    """
    frame = model.frames[frame_id(model, foot)]
    on = [shape for shape in shapes if shape.joint == frame.parentJoint]
    if not on:
        raise RobotFileError(
            f"{where}: the link that carries {foot} has no collision geometry; expected some "
            "there, for its sole is measured from it"
        )
    rotation = data.oMi[frame.parentJoint].rotation.T  # of base axes against the joint's
    rpy = pin.rpy.matrixToRpy(frame.placement.rotation.T @ rotation)
    turned = bool(np.abs(rpy).max() > _TURNED)
    straight = pin.SE3(rotation, frame.placement.translation)
    if turned and np.linalg.norm(pin.log3(pin.rpy.rpyToMatrix(rpy))) < _UPRIGHT:
        turned = _lies_flat(straight, on) or not _lies_flat(frame.placement, on)
    level = pin.SE3(rotation if turned else frame.placement.rotation, frame.placement.translation)
    points = _corners_of(level, on)
    low, high = points.min(axis=0), points.max(axis=0)
    middle = np.append((low + high)[:2] / 2, low[2])
    if np.abs(middle).max() <= _OFF_THE_MIDDLE and not turned:
        return None
    x, y, z = (frame.placement.inverse() * level).act(middle)
    roll, pitch, yaw = rpy if turned else np.zeros(3)
    return AddedFrame(
        link=foot,
        xyz=(round(x, 4) + 0.0, round(y, 4) + 0.0, round(z, 4) + 0.0),
        rpy=(round(roll, 6) + 0.0, round(pitch, 6) + 0.0, round(yaw, 6) + 0.0),
    )


def _lies_flat(frame: pin.SE3, shapes: list[PlacedSolid]) -> bool:
    """Whether ground across the frame's z axis touches half of the shapes, along and across."""
    points = _corners_of(frame, shapes)
    touching = points[points[:, 2] < points[:, 2].min() + _EVEN]
    return bool((np.ptp(touching[:, :2], axis=0) > np.ptp(points[:, :2], axis=0) / 2).all())


def new_name(name: str, model: pin.Model) -> str:
    """A name that no frame of the model has, from one that may."""
    while any(model.existFrame(taken) for taken in (name, f"{name}_fixed")):
        name += "_middle"
    return name


def contact_points(
    frame: pin.Frame, shapes: list[PlacedSolid], *, sole: bool
) -> tuple[tuple[tuple[float, float], ...], float | None]:
    """Contact points of a foot in its frame, and their radius where the URDF has no spheres."""
    shapes = [shape for shape in shapes if shape.joint == frame.parentJoint]
    spheres = [s for s in shapes if s.is_sphere]
    if not sole:
        radius = None if spheres else ball_radius(frame, shapes)
        return ((0.0, 0.0),), radius
    inside = frame.placement.inverse()
    if len(spheres) == _CORNERS:
        centres = np.array([inside.act(sphere.placement.translation) for sphere in spheres])
        order = np.lexsort((-centres[:, 1], -np.sign(centres[:, 0] - centres[:, 0].mean())))
        return tuple((round(float(x), 4), round(float(y), 4)) for x, y, _ in centres[order]), None
    points = _corners_of(frame.placement, shapes)
    low, high = points.min(axis=0), points.max(axis=0)
    radius = min(0.01, (high - low)[:2].min() / 6)
    x, y = (np.array([high[axis], low[axis]]) for axis in (0, 1))
    x, y = x - np.sign(x) * radius, y - np.sign(y) * radius
    corners = tuple((round(float(a), 3), round(float(b), 3)) for a in x for b in y)
    return corners, None if len(spheres) >= len(corners) else round(float(radius), 4)


def _corners_of(frame: pin.SE3, shapes: list[PlacedSolid]) -> Array:
    """(N, 3) m: corners of the shapes, in a frame that is placed in that of the same joint."""
    inside = frame.inverse()
    points = [shape.corners @ inside.rotation.T + inside.translation for shape in shapes]
    return np.concatenate([np.empty((0, 3)), *points])


def ball_radius(frame: pin.Frame, shapes: list[PlacedSolid]) -> float:
    """Half of what the shape around a point foot measures neither along nor across it, m.

    Of a capsule, a cylinder and a disc it is the radius, however long or thin they are.
    """
    around = [
        points
        for points in (_corners_of(frame.placement, [shape]) for shape in shapes)
        if (points.min(axis=0) - 1e-3 <= 0).all() and (points.max(axis=0) + 1e-3 >= 0).all()
    ]
    if not around:
        return BALL
    smallest = min(around, key=lambda points: float(np.ptp(points, axis=0).max()))
    return round(float(np.clip(np.median(np.ptp(smallest, axis=0)) / 2, 0.005, 0.04)), 4)
