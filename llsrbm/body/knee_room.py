"""How thick legs are at their knees, by the shapes of thighs and shanks."""

from functools import lru_cache

import coal
import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.body.trunk_and_knees import knee_joint
from llsrbm.robots.robot import Leg, Robot
from llsrbm.robots.shapes import Shape, link_shapes

_FAN = np.radians(np.linspace(-60.0, 60.0, 13))  # about the thigh's direction, as it may be tilted
_FAR = 10.0  # m, where a half-space begins from which distances are measured


@lru_cache(maxsize=16)
def knee_room(robot: Robot) -> float:
    """The farthest (m) that thighs reach beyond their knees; 0 of robots without knees.

    In the plane in which a leg bends, within 60 degrees of the direction from the hip.
    """
    joint = knee_joint(robot)
    if joint is None:
        return 0.0
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.posture)
    return max(_beyond(robot, data, leg, joint) for leg in robot.legs)


@lru_cache(maxsize=16)
def knee_width(robot: Robot) -> float:
    """The farthest (m) that shanks reach sideways from their knees, towards the robot's middle.

    In the default posture; 0 of robots without knees.
    """
    joint = knee_joint(robot)
    if joint is None:
        return 0.0
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.posture)
    widths = [0.0]
    for leg, hip in zip(robot.legs, robot.hips, strict=True):
        if hip[1] == 0.0:  # in the middle, as a third leg: it has none beside it
            continue
        inwards = np.array([0.0, -np.sign(hip[1]), 0.0])
        shank = data.oMi[leg.joint_ids[joint]]
        shapes = (x for x in link_shapes(robot) if x.joint == leg.joint_ids[joint] and not x.foot)
        middle = float(inwards @ shank.translation)
        widths += [_reach(x, shank, inwards) - middle for x in shapes]
    return max(widths)


def _beyond(robot: Robot, data: pin.Data, leg: Leg, joint: int) -> float:
    thigh = leg.joint_ids[joint - 1]
    knee, foot = data.oMi[leg.joint_ids[joint]].translation, data.oMf[leg.foot_frame_id].translation
    along = knee - data.oMi[thigh].translation
    along /= np.linalg.norm(along)
    aside = foot - knee - along * (along @ (foot - knee))
    aside /= np.linalg.norm(aside)
    directions = np.outer(np.cos(_FAN), along) + np.outer(np.sin(_FAN), aside)
    shapes = [x for x in link_shapes(robot) if x.joint == thigh and not x.foot]
    return max(
        (_reach(x, data.oMi[thigh], d) - float(d @ knee) for x in shapes for d in directions),
        default=0.0,
    )


def _reach(shape: Shape, joint: pin.SE3, towards: Array) -> float:
    """The largest coordinate (m) of a shape along a direction of the world."""
    place = joint * pin.SE3(shape.rotation, shape.centre)
    here, there = coal.Transform3s(place.rotation, place.translation), coal.Transform3s()
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    beyond = coal.Halfspace(-towards, -_FAR)
    return _FAR - float(coal.distance(shape.geometry(), here, beyond, there, request, result))
