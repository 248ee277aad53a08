"""A robot's limbs in numbers, and the kind of chain that each is.

A limb is a chain of joints on the trunk. Its masses and lengths are numbers, and the kind of chain
alone decides the expressions (`chain`): so a function is derived once for all legs of a kind, and
for all robots that have such legs. Links have the base's axes where all joints are at zero, so that
no rotation of the URDF is left in the expressions.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from llsrbm.body.trunk_and_knees import knee_joint
from llsrbm.models.drive_losses import DriveLosses
from llsrbm.models.rigid_bodies import RigidBodies
from llsrbm.robots.feet import foot_contacts
from llsrbm.robots.robot import Robot
from llsrbm.robots.urdf import BASE_JOINT

Array = NDArray[np.float64]

ALIGNED = 1e-9  # of an axis: components below it are none
LINK = {
    "mass": 1,
    "moment": 3,
    "inertia": 6,
}  # about its joint: kg, kg m, kg m2 (xx xy xz yy yz zz)
JOINT = {"axis": 3, "arm": 3, "armature": 1, "friction": 1, "damping": 1, "width": 1}


class JointKind(NamedTuple):
    """Whether a joint slides, and which components its axis has at zero."""

    slides: bool
    along: tuple[int, ...]


@dataclass(frozen=True)
class LimbKind:
    """All that a limb's expressions depend on.

    Attributes:
        joints: base outwards; corners: contact points of its foot, 0: it is an arm.
        knee: which of its joints is the knee, if one is.
    """

    joints: tuple[JointKind, ...]
    corners: int
    knee: int | None

    @property
    def of_foot(self) -> dict[str, int]:
        """Name -> number of the numbers of its foot, in the axes of the link that carries it at
        zero: the frame's place and axes, contact points, the balls' middles and radius from the
        frame, m, and the height of the frame above what it stands on.
        """
        points = 3 * self.corners
        each = {"place": 3, "axes": 9, "contacts": points, "balls": points, "radius": 1, "lift": 1}
        return each if self.corners else {}

    @property
    def numbers(self) -> dict[str, int]:
        """Name -> number of its numbers, in order: joint after joint, then the foot."""
        found: dict[str, int] = {}
        for i in range(len(self.joints)):
            found |= {f"{name} {i}": size for name, size in (JOINT | LINK).items()}
        return found | self.of_foot

    @property
    def given(self) -> dict[str, int]:
        """Name -> number of the numbers of its functions: its own, then the normal of the ground
        that its foot stands on, world axes.
        """
        return self.numbers | ({"normal": 3} if self.corners else {})


@dataclass(frozen=True, eq=False)
class Limb:
    """A robot's limb: its kind, its joints among the robot's, and its numbers."""

    kind: LimbKind
    joints: tuple[int, ...]
    numbers: Array


@lru_cache(maxsize=16)
def limbs_of(robot: Robot) -> tuple[Limb, ...]:
    """All limbs: legs in their order, then the arms; each joint belongs to one."""
    found = _Reader(robot).limbs()
    joints = sorted(joint for limb in found for joint in limb.joints)
    assert joints == list(range(len(robot.joint_names))), robot.name
    return found


def trunk_numbers(robot: Robot) -> Array:
    """(10,) `LINK` of the base, in its axes."""
    return _of_link(robot.model.inertias[BASE_JOINT], np.eye(3))


class _Reader:
    def __init__(self, robot: Robot) -> None:
        self.robot, self.model = robot, robot.model
        self.bodies, self.losses = RigidBodies(robot), DriveLosses.of(robot)

    def limbs(self) -> tuple[Limb, ...]:
        robot, model = self.robot, self.model
        knee, found = knee_joint(robot), []
        contacts = foot_contacts(robot)
        for leg, contact in zip(robot.legs, contacts, strict=True):
            frame = model.frames[leg.foot_frame_id]
            chain = self.bodies.chain(frame.parentJoint)
            R = self._at_zero(chain[-1])
            axes = R @ frame.placement.rotation
            place = R @ frame.placement.translation
            points = [*(place + contact.above @ axes.T), *(contact.centres @ axes.T)]
            foot = [place, axes.ravel(order="F"), *points, [contact.radius, contact.lift]]
            found.append(self._limb(chain, len(robot.corners), knee, np.concatenate(foot)))
        carried = {joint for limb in found for joint in limb.joints}
        ends = set(range(BASE_JOINT + 1, model.njoints)) - set(model.parents)
        for end in sorted(ends):
            chain = self.bodies.chain(end)
            if not {self.bodies.link(i).joint for i in chain} & carried:
                found.append(self._limb(chain, 0, None, np.zeros(0)))
        return tuple(found)

    def _at_zero(self, joint: int) -> Array:
        """(3, 3) a link's axes in the base's with all joints at zero."""
        R = np.eye(3)
        while joint != BASE_JOINT:
            R = np.array(self.model.jointPlacements[joint].rotation) @ R
            joint = int(self.model.parents[joint])
        return R

    def _limb(self, chain: list[int], corners: int, knee: int | None, foot: Array) -> Limb:
        kinds, numbers, joints = [], [], []
        before = np.eye(3)
        for i in chain:
            link, R = self.bodies.link(i), self._at_zero(i)
            axis = R @ link.axis
            axis = np.where(np.abs(axis) < ALIGNED, 0.0, axis)
            kinds.append(JointKind(link.slides, tuple(np.flatnonzero(axis).tolist())))
            own = [getattr(self.losses, name)[link.joint] for name in list(JOINT)[2:]]
            numbers += [axis, before @ link.origin, own, _of_link(self.model.inertias[i], R)]
            joints.append(link.joint)
            before = R
        kind = LimbKind(tuple(kinds), corners, knee)
        return Limb(kind, tuple(joints), np.concatenate([*numbers, foot]))


def _of_link(inertia: Any, R: Array) -> Array:
    """`LINK` of Pinocchio's inertia, in axes turned by R."""
    com = R @ inertia.lever
    about = inertia.mass * (com @ com * np.eye(3) - np.outer(com, com))
    about += R @ inertia.inertia @ R.T
    return np.concatenate([[inertia.mass], inertia.mass * com, about[np.triu_indices(3)]])
