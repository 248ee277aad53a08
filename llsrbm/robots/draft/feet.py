"""Contacts of a URDF's feet with the ground, by their collision geometry."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.errors import RobotFileError
from llsrbm.robots.urdf import frame_id
from llsrbm.robots.urdf_table import AddedFrame

Array = NDArray[np.float64]

_CORNERS = 4  # of a sole
_OFF_THE_MIDDLE = 0.01  # m from a sole's frame to the middle of the sole on the ground
_TURNED = 1e-3  # rad, likewise


def middle_of_sole(
    model: pin.Model, data: pin.Data, foot: str, shapes: list[pin.GeometryObject], urdf: Path
) -> AddedFrame | None:
    """Where the frame of a sole belongs, seen from the link at the end of its leg; None: there.

    With all joints at zero soles are level and point forward.
    """
    frame = model.frames[frame_id(model, foot)]
    on = [shape for shape in shapes if shape.parentJoint == frame.parentJoint]
    if not on:
        raise RobotFileError(
            f"{urdf}: the link that carries {foot} has no collision geometry; expected some "
            "there, for its sole is measured from it"
        )
    rotation = data.oMi[frame.parentJoint].rotation.T  # of base axes against the joint's
    rpy = pin.rpy.matrixToRpy(frame.placement.rotation.T @ rotation)
    turned = bool(np.abs(rpy).max() > _TURNED)
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


def new_name(name: str, model: pin.Model) -> str:
    """A name that no frame has yet."""
    while any(model.existFrame(taken) for taken in (name, f"{name}_fixed")):
        name += "_middle"
    return name


def contact_points(
    frame: pin.Frame, shapes: list[pin.GeometryObject], *, sole: bool
) -> tuple[tuple[tuple[float, float], ...], float | None]:
    """Contact points of a foot in its frame, and their radius where the URDF has no spheres."""
    import coal

    shapes = [shape for shape in shapes if shape.parentJoint == frame.parentJoint]
    spheres = [s for s in shapes if isinstance(s.geometry, coal.Sphere)]
    if not sole:
        radius = None if spheres else _ball_radius(frame, shapes)
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


def _corners_of(frame: pin.SE3, shapes: list[pin.GeometryObject]) -> Array:
    """(N, 3) m: corners of the shapes' boxes, in a frame, placed in that of the same joint."""
    signs = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    points = [np.empty((0, 3))]
    for shape in shapes:
        shape.geometry.computeLocalAABB()
        box = shape.geometry.aabb_local
        inside = box.min_ + signs * (box.max_ - box.min_)
        placement = frame.inverse() * shape.placement
        points.append(inside @ placement.rotation.T + placement.translation)
    return np.concatenate(points)


def _ball_radius(frame: pin.Frame, shapes: list[pin.GeometryObject]) -> float:
    """Half of what the shape around a point foot measures where it is thinnest, m."""
    around = [
        points
        for points in (_corners_of(frame.placement, [shape]) for shape in shapes)
        if (points.min(axis=0) - 1e-3 <= 0).all() and (points.max(axis=0) + 1e-3 >= 0).all()
    ]
    if not around:
        return 0.02
    smallest = min(around, key=lambda points: float(np.ptp(points, axis=0).max()))
    return round(float(np.clip(np.ptp(smallest, axis=0).min() / 2, 0.005, 0.04)), 4)
