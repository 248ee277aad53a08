"""A URDF as a robot file wants it: joints that are held made fixed, frames added.

All that reads the robot reads the changed one: Pinocchio, MuJoCo, pictures, exports, the hashes
that it is known by.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pinocchio as pin

from llsrbm.errors import RobotFileError
from llsrbm.request.messages import choices
from llsrbm.robots.description.parts import (
    Description,
    Joint,
    Link,
    Origin,
    Solid,
    Vector,
)
from llsrbm.robots.schema import AddedFrame, UrdfSource

_DIGITS = 12  # after the point, so that machines agree on the text and thus on its hash

STOP = 1e-4
"""rad or m by which an angle may exceed a limit: both are rounded in files."""


def changed(
    robot: Description, source: UrdfSource, feet: Mapping[str, str], path: str
) -> Description:
    """The robot with joints held and frames added.

    Args:
        source: what is held and added.
        feet: leg -> frame of its foot; joints that move one but not all cannot be held.
        path: of the robot file, for messages.

    Raises:
        RobotFileError: a joint or link is not there, an angle is beyond its joint's limits or not
            what its joint mimics, or a held joint is one of a leg.
    """
    links, joints = dict(robot.links), dict(robot.joints)
    # Frames first: a foot may be one, and what carries it must not be held either.
    for name, frame in source.frames.items():
        _check_frame(name, frame, links, joints, path)
        ball = () if frame.radius is None else (Solid("sphere", Origin(), (frame.radius,)),)
        links[name] = Link(name, collisions=ball)
        joint = f"{name}_fixed"
        origin = Origin(_rounded(frame.xyz), _rounded(frame.rpy))
        joints[joint] = Joint(joint, "fixed", frame.link, name, origin)
    _check_no_leg_is_held(joints, source.held, feet, path)
    for name, angle in source.held.items():
        _check_angle(name, source.held, joints, path)
        joints[name] = _held(joints[name], angle)
    return replace(robot, links=links, joints=joints)


def _check_frame(
    name: str,
    frame: AddedFrame,
    links: Mapping[str, Link],
    joints: Mapping[str, Joint],
    path: str,
) -> None:
    taken = {*links, *joints}
    if name in taken or f"{name}_fixed" in taken:
        raise RobotFileError(
            f'{path}: urdf.frames.{name}: the URDF has a link or joint of that name, or "'
            f'{name}_fixed"; expected a new name'
        )
    if frame.link not in links:
        raise RobotFileError(
            f'{path}: urdf.frames.{name}.link: the URDF has no link "{frame.link}"; '
            f"{choices(frame.link, links)}"
        )


def _check_angle(
    name: str, held: Mapping[str, float], joints: Mapping[str, Joint], path: str
) -> None:
    """An angle at which a joint is held: rad, or m if it slides."""
    movable = [other for other, joint in joints.items() if joint.moves]
    if name not in movable:
        raise RobotFileError(
            f'{path}: urdf.held: the URDF has no joint "{name}" that turns or slides; '
            f"{choices(name, movable)}"
        )
    joint, angle = joints[name], held[name]
    limit = joint.limit
    within = limit is None or limit.lower - STOP <= angle <= limit.upper + STOP
    if limit is not None and joint.kind != "continuous" and not within:
        raise RobotFileError(
            f"{path}: urdf.held.{name}: expected {limit.lower:g} to {limit.upper:g} "
            f"{joint.unit}, as the URDF limits it, got {angle:g}"
        )
    mimic = joint.mimic
    if mimic is None:
        return
    if mimic.joint not in held:
        raise RobotFileError(
            f"{path}: urdf.held.{name}: it mimics {mimic.joint}, which is not held; expected both "
            "held, or neither"
        )
    wanted = mimic.multiplier * held[mimic.joint] + mimic.offset
    if abs(wanted - angle) > STOP:
        raise RobotFileError(
            f"{path}: urdf.held.{name}: it mimics {mimic.joint}; expected {wanted:g} {joint.unit} "
            f"for {held[mimic.joint]:g}, got {angle:g}"
        )


def _held(joint: Joint, angle: float) -> Joint:
    """Fixed where it takes its child at an angle."""
    origin = joint.origin
    if angle:
        along = np.array(joint.axis) / np.linalg.norm(joint.axis)
        start = origin.placement
        if joint.slides:
            xyz = start.translation + start.rotation @ along * angle
            origin = Origin(_rounded(xyz), _rounded(origin.rpy))
        else:
            turned = start.rotation @ pin.AngleAxis(angle, along).toRotationMatrix()
            origin = Origin(_rounded(origin.xyz), _rounded(pin.rpy.matrixToRpy(turned)))
    return Joint(joint.name, "fixed", joint.parent, joint.child, origin)


def _check_no_leg_is_held(
    joints: Mapping[str, Joint], held: Mapping[str, float], feet: Mapping[str, str], path: str
) -> None:
    carries = {joint.child: joint for joint in joints.values()}
    moving: dict[str, list[str]] = {}  # joint -> legs whose feet it moves
    for leg, frame in feet.items():
        # A foot's frame may be a link or a joint; what the URDF does not have is told later.
        link = joints[frame].child if frame in joints else frame
        while link in carries:
            moving.setdefault(carries[link].name, []).append(leg)
            link = carries[link].parent
    # A waist between the root and all legs makes one trunk of both.
    of_legs = {name for name, legs in moving.items() if len(legs) < max(len(feet), 2)}
    for name in held:
        if name in of_legs:
            others = [n for n, joint in joints.items() if joint.moves and n not in of_legs]
            raise RobotFileError(
                f"{path}: urdf.held.{name}: it moves the foot of leg {moving[name][-1]}; expected "
                f"joints that move no foot, or all: {', '.join(others) or 'there are none'}"
            )


def _rounded(values: object) -> Vector:
    x, y, z = (round(float(value), _DIGITS) + 0.0 for value in np.ravel(np.asarray(values)))
    return x, y, z
