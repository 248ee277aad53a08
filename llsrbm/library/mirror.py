"""The mirror image of a motion, on a robot whose left side is its right one in a mirror.

With the mirror M = diag(1, -1, 1) in the base's xz plane, vectors become M x, and what turns (rates
and axes of rotation) becomes -M x; a quaternion w, x, y, z becomes w, -x, y, -z. A joint changes
places with the one that lies where its image is, and its sign where that one's axis is not the
image of its own. The image is checked like any other motion: a robot that is less symmetric than
its joints has other torques in it, and forces that do not fit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.errors import InputError
from llsrbm.library.card import Card, kind_of, rounded_request
from llsrbm.library.file import StoredMotion
from llsrbm.library.stored import motion_of, row_of
from llsrbm.motion.plan import Plan
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.request.jump import Jump
from llsrbm.request.jump_types import schedule_of
from llsrbm.request.stones import Stone
from llsrbm.robots import load_robot
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]
Order = NDArray[np.int64]

_MIRROR = np.array([1.0, -1.0, 1.0])
_QUAT = np.array([1.0, -1.0, 1.0, -1.0])
_SAME_PLACE = 5e-3  # m: robots are symmetric to a few millimetres
_PARALLEL = 0.99  # of the cosine of two axes
_TURNING = ("twist", "lateral", "roll", "cross_slope", "takeoff_cross_slope")
_OF_LANDINGS = ("twist", "lateral", "cross_slope")


class Sides(NamedTuple):
    """For each joint, leg and corner of a foot the one that lies where its image is."""

    joints: Order
    signs: Array  # of each joint: what its image's angle is times
    legs: Order
    corners: Order


def sides_of(robot: Robot) -> Sides:
    """A robot's sides. Raises `InputError`: a joint, a leg or a corner of a foot has no image."""
    places, axes, slides = _joints(robot)
    images = _MIRROR * axes * np.where(slides, 1.0, -1.0)[:, None]
    apart = np.linalg.norm((_MIRROR * places)[:, None] - places, axis=-1)
    along = images @ axes.T
    fits = (apart < _SAME_PLACE) & (np.abs(along) > _PARALLEL) & (slides[:, None] == slides)
    for name, images_of in zip(robot.joint_names, fits, strict=True):
        if images_of.sum() != 1:
            raise InputError(f"{robot.name}: {name} has no image in a mirror")
    source = fits.argmax(axis=0)  # of each joint the one whose image it is
    corners = [f"corner {k}" for k in range(len(robot.corners))]
    return Sides(
        joints=source,
        signs=np.sign(along[source, np.arange(len(source))]),
        legs=_images(np.array(robot.hips), robot.leg_names, robot),
        corners=_images(np.array(robot.corners), corners, robot),
    )


_sides_of = lru_cache(maxsize=32)(sides_of)


def _joints(robot: Robot) -> tuple[Array, Array, NDArray[np.bool_]]:
    """(J, 3) m, (J, 3) and (J,): where joints are at zero angles, their axes, which of them slide;
    in axes of the base, in the order of `Robot.joint_names`.
    """
    model, data = robot.model, robot.model.createData()
    pin.computeJointJacobians(model, data, pin.neutral(model))
    frame = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    places, columns = [], []
    for joint in range(2, model.njoints):  # behind the root
        places.append(data.oMi[joint].translation.copy())
        columns.append(pin.getJointJacobian(model, data, joint, frame)[:, model.idx_vs[joint]])
    linear, angular = np.split(np.array(columns), 2, axis=1)
    slides = np.linalg.norm(angular, axis=1) < np.linalg.norm(linear, axis=1)
    return np.array(places), np.where(slides[:, None], linear, angular), slides


def _images(points: Array, names: Sequence[str], robot: Robot) -> Order:
    """(n,) for each of the points (n, 3) the one at its image."""
    apart = np.linalg.norm((_MIRROR * points)[:, None] - points, axis=-1)
    found: Order = apart.argmin(axis=1)
    for name, least in zip(names, apart.min(axis=1), strict=True):
        if least > _SAME_PLACE:
            raise InputError(f"{robot.name}: {name} has no image in a mirror")
    return found


def mirrored(card: Card, plan: Plan, robot: Robot) -> StoredMotion:
    """The image of a motion, which is not checked yet (`llsrbm.library.library.checked`).

    Raises `InputError`: robot or jump type have no image, or the motion is its own.
    """
    sides = sides_of(robot)
    request = mirrored_jump(card.request, robot, sides)
    if rounded_request(request) == rounded_request(card.request):
        raise InputError(f"{card.name}: it is its own image in a mirror")
    stands = schedule_of(card.request, robot).stands
    if not np.array_equal(schedule_of(request, robot).stands, stands[:, sides.legs]):
        raise InputError(f"{card.name}: jump type {card.type} has no image in a mirror")
    grid = Grid.under(plan)
    motion = motion_of(plan, robot, grid)
    changed = {
        "position": lambda values: values * _MIRROR,
        "quat": lambda values: values * _QUAT,
        "velocity": lambda values: values * _MIRROR,
        "acceleration": lambda values: values * _MIRROR,
        "omega": lambda values: values * -_MIRROR,
        "omega_rate": lambda values: values * -_MIRROR,
        "durations": lambda values: values,
    }

    def turned(values: Array) -> Array:
        return sides.signs * values[..., sides.joints]

    feet = motion.force.reshape(*motion.force.shape[:2], len(sides.legs), len(sides.corners), 3)
    force = feet[:, :, sides.legs][:, :, :, sides.corners] * _MIRROR
    image = replace(
        motion,
        state={name: changed.get(name, turned)(each) for name, each in motion.state.items()},
        rates={name: changed.get(name, turned)(each) for name, each in motion.rates.items()},
        force=force.reshape(motion.force.shape),
    )
    numbers = row_of(image, plan.foot_quat[:, sides.legs] * _QUAT, robot, grid)
    found = {"request": request, "kind": kind_of(request), "drawn": None}
    return StoredMotion(card.model_copy(update=found), numbers)


def image_of(card: Card) -> Jump:
    """The image of a motion's request; the request itself where the robot has no other side."""
    robot = load_robot(card.robot)
    try:
        return mirrored_jump(card.request, robot, _sides_of(robot))
    except InputError:
        return card.request


def mirrored_jump(jump: Jump, robot: Robot, sides: Sides) -> Jump:
    """The image of a request."""
    changed: dict[str, Any] = {name: _other(getattr(jump, name)) for name in _TURNING}
    if jump.payload:
        mass, x, y, z = jump.payload
        changed["payload"] = mass, x, _other(y), z
    changed["stones"] = tuple(
        Stone(robot.leg_names[sides.legs[robot.leg_names.index(leg)]], x, _other(y), z)
        for leg, x, y, z in jump.stones
    )
    changed["route"] = tuple(
        landing._replace(**{name: _other(getattr(landing, name)) for name in _OF_LANDINGS})
        for landing in jump.route
    )
    return replace(jump, **changed)


def _other(value: float) -> float:
    return 0.0 - value
