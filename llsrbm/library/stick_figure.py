"""The stick figure of a motion: few points of its robot, for moving pictures in lists of motions.

The points are the corners of the trunk's box, joints of the limbs and their ends, at 32 instants
evenly over the motion. They are seen from far away by a camera that stands still: to the right of
the robot that takes off, a little ahead of it and above. `stick_figure.js` draws them.
"""

from __future__ import annotations

import base64
from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache
from itertools import product
from typing import Any, Self

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.arrays import Array
from llsrbm.body.trunk_and_knees import trunk_box
from llsrbm.motion.plan import Plan
from llsrbm.motion.robot import robot_of
from llsrbm.motion.whole_body import motion_at, pinocchio_states
from llsrbm.robots.robot import Arm, Leg, Robot
from llsrbm.robots.urdf import BASE_JOINT

Bytes = NDArray[np.int8]

INSTANTS = 32
LARGEST = 127  # of a coordinate
AZIMUTH, ELEVATION = np.radians(25.0), np.radians(14.0)  # ahead of the robot's right, and above
_SHORT = 0.15  # of a limb's length: joints nearer to the one before it have no point
_MOST_POINTS = 100


class Role(IntEnum):
    """The part of a robot that a point belongs to."""

    TRUNK = 0  # a corner of its box, of which the outline is drawn
    LIMB = 1
    FOOT = 2  # where a foot ends; these span the ground that the robot stands on first and last


@dataclass(frozen=True, eq=False)
class StickFigure:
    """P points of a robot at T instants, as they are seen.

    Attributes:
        links: (P,) number of the point that each is joined with; its own where there is none.
        roles: (P,) of each, a `Role`.
        points: (T, P, 2) to the right and up, in one scale for both: the rectangle that the whole
            motion takes has its middle at 0, and its longer side reaches from -127 to 127.
    """

    links: Bytes
    roles: Bytes
    points: Bytes

    @classmethod
    def of(cls, plan: Plan) -> Self:
        """A motion's.

        Raises:
            InputError: the robot has other joints by now.
            RobotFileError: the robot is not there, or its trunk has no shape.
        """
        bones = skeleton(robot_of(plan))
        seen = projected(positions(plan))
        low, high = seen.min(axis=(0, 1)), seen.max(axis=(0, 1))
        step = (high - low).max() / (2 * LARGEST)
        points = np.round((seen - (low + high) / 2) / step).astype(np.int8)
        return cls(
            np.array([bone.link for bone in bones], dtype=np.int8),
            np.array([bone.role for bone in bones], dtype=np.int8),
            points,
        )

    @classmethod
    def of_array(cls, array: NDArray[Any]) -> Self:
        """The one of an `array`. Raises `ValueError`: it is of none."""
        if array.dtype != np.int8 or array.ndim != 3 or array.shape[2] != 2:
            raise ValueError("expected rows of pairs in int8")
        if len(array) < 3 or not 0 < array.shape[1] <= _MOST_POINTS:
            raise ValueError(f"expected two instants or more of 1 to {_MOST_POINTS} points")
        links, roles = array[0, :, 0], array[0, :, 1]
        if not ((links >= 0) & (links < len(links)) & np.isin(roles, list(Role))).all():
            raise ValueError("expected links among its points, and roles that are known")
        return cls(links, roles, array[1:])

    @property
    def array(self) -> Bytes:
        """(1 + T, P, 2): links and roles, then the points."""
        return np.concatenate([np.stack([self.links, self.roles], axis=1)[None], self.points])

    def drawn(self, duration: float) -> dict[str, Any]:
        """Plain data for `stick_figure.js`; `duration`: of the motion, s."""
        text = base64.b64encode(self.array.tobytes()).decode("ascii")
        return {"points": len(self.links), "duration": round(duration, 3), "bytes": text}


@dataclass(frozen=True, eq=False)
class Bone:
    """A point of a robot, and the line from it to another one.

    Attributes:
        joint: index in `Robot.model`; place: (3,) m in its frame.
        link: number of the other point; its own where there is none.
    """

    joint: int
    place: Array
    link: int
    role: Role


def positions(plan: Plan) -> Array:
    """(T, P, 3) m, world frame: the points of a motion's robot. Raises as `StickFigure.of` does."""
    times = np.linspace(plan.time[0], plan.time[-1], INSTANTS)
    motion = motion_at(plan, times)
    bones = skeleton(motion.robot)
    model, data = motion.robot.model, motion.robot.model.createData()
    states, _ = pinocchio_states(motion.qpos, motion.qvel)
    found = np.empty((len(times), len(bones), 3))
    for k, q in enumerate(states):
        pin.forwardKinematics(model, data, q)
        for p, bone in enumerate(bones):
            found[k, p] = data.oMi[bone.joint].act(bone.place)
    return found


def projected(points: Array) -> Array:
    """(..., 2) m, to the right and up, of points (..., 3) m in the world frame."""
    right = np.array([np.cos(AZIMUTH), np.sin(AZIMUTH), 0.0])
    away = np.array([-np.sin(AZIMUTH), np.cos(AZIMUTH), 0.0])
    up = np.array([0.0, 0.0, np.cos(ELEVATION)]) + np.sin(ELEVATION) * away
    return np.stack([points @ right, points @ up], axis=-1)


@lru_cache(maxsize=32)
def skeleton(robot: Robot) -> tuple[Bone, ...]:
    """The points of a robot. Raises `RobotFileError`: its trunk has no collision geometry."""
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.posture)
    base = data.oMi[BASE_JOINT]
    held = [base.actInv(data.oMi[limb.joint_ids[0]].translation) for limb in robot.legs]
    box = np.concatenate([trunk_box(robot), held])
    corners = product(*zip(box.min(axis=0), box.max(axis=0), strict=True))
    bones = [
        Bone(BASE_JOINT, np.array(corner), number, Role.TRUNK)
        for number, corner in enumerate(corners)
    ]
    limbs: tuple[Leg | Arm, ...] = (*robot.legs, *robot.arms)
    for limb in limbs:
        bones += _limb(robot, limb, data, len(bones))
    return tuple(bones)


def _limb(robot: Robot, limb: Leg | Arm, data: pin.Data, first: int) -> list[Bone]:
    """A limb's points from the base outwards; the first of them is number `first`."""
    if isinstance(limb, Leg):
        end, role, ends = limb.foot_frame_id, Role.FOOT, _heel_and_toe(robot.corners)
    else:
        end, role, ends = limb.hand_frame_id, Role.LIMB, np.zeros((1, 3))
    places = [data.oMi[joint].translation for joint in limb.joint_ids]
    along = np.diff([*places, data.oMf[end].translation], axis=0)
    least = _SHORT * np.linalg.norm(along, axis=1).sum()
    bones, last = [Bone(limb.joint_ids[0], np.zeros(3), first, Role.LIMB)], places[0]
    for joint, place in zip(limb.joint_ids, places, strict=True):
        if np.linalg.norm(place - last) > least:
            link, last = first + len(bones) - 1, place
            bones.append(Bone(joint, np.zeros(3), link, Role.LIMB))
    link, frame = first + len(bones) - 1, robot.model.frames[end]
    places = [frame.placement.act(point) for point in ends]
    return [*bones, *(Bone(frame.parentJoint, place, link, role) for place in places)]


def _heel_and_toe(corners: Array) -> Array:
    """(1 or 2, 3) m: where a foot with these contact points (c, 3) ends behind and ahead."""
    ahead = corners[:, 0]
    ends = [corners[ahead == edge].mean(axis=0) for edge in sorted({ahead.min(), ahead.max()})]
    return np.array(ends)
