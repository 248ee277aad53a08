"""`Robot`: a robot file together with everything computed from its URDF."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array, IntArray
from llsrbm.errors import InputError
from llsrbm.robots.description import Description
from llsrbm.robots.drives.table import (
    ARMATURE_PER_TORQUE,
    DAMPING_PER_TORQUE,
    DELAY,
    FRICTION_PER_TORQUE,
)
from llsrbm.robots.leg_maps import LegFit
from llsrbm.robots.legs import LegChains
from llsrbm.robots.schema import RobotFile

PerLimb = float | tuple[float, ...] | None
"""One number for all joints of a limb, or one each from the base outwards; None: there are none."""

# Share of a joint's range that plans and the controller keep from either stop. The controller
# brakes what is planned nearer: an A1 whose feet rolled unplanned left the ground by 52 mm/s too
# slowly as it crouched, by 5 without the controller's bound, by 46 with this margin in its plan.
STOP_MARGIN = 0.01
_BASE_JOINT = 1  # Pinocchio's index of the free flyer
# What of a robot file no plan depends on.
_NOT_OF_PLANS: Any = {
    **dict.fromkeys(("control", "uncertainty", "example", "link_pairs", "wire"), True),
    "turning": {"axes": True},
    "limits": {"regeneration": True},
    "drives": {"delay", "known", "spread", "friction_range", "electrical"},
}


@dataclass(frozen=True, eq=False)
class Limb:
    """One leg or arm, base outwards: n joints.

    Attributes:
        joints, joint_ids: names of the joints, and their indices in `Robot.model`.
        q_index, v_index: (n,) where they stand in Pinocchio's q and v.
    """

    name: str
    joints: tuple[str, ...]
    joint_ids: tuple[int, ...]
    q_index: IntArray
    v_index: IntArray


@dataclass(frozen=True, eq=False)
class Leg(Limb):
    """A limb that stands.

    Attributes:
        foot_frame, foot_frame_id: the contact point's frame, and its index in `Robot.model`.
        hip: (3,) m: origin of the file's hip joint at zero joint angles, base frame.
        mirror: (3,) of +1 or -1: diag(mirror) maps this leg onto the reference leg.
    """

    foot_frame: str
    foot_frame_id: int
    hip: Array
    mirror: Array


@dataclass(frozen=True, eq=False)
class Arm(Limb):
    """A limb that never stands.

    Attributes:
        hand_frame, hand_frame_id: the frame at its end, and its index in `Robot.model`.
        mirror: (n,) of +1 or -1: by which its joint angles are those of the first arm, mirrored.
    """

    hand_frame: str
    hand_frame_id: int
    mirror: Array


@dataclass(frozen=True, eq=False, repr=False)
class Robot:
    """A robot as the rest of the library sees it: L legs, A arms, J joints.

    The default posture stands level on the ground, the lowest foot's lowest point at z = 0, the CoM
    above the world's origin; soles lie flat, the CoM above what they span.

    Attributes:
        file: the robot file's content; path: where it lies.
        urdf_path: the URDF that the file names; urdf_source: what it says.
        urdf: the same with the file's held joints fixed and its frames added.
        model: Pinocchio model with a free flyer at the root link and the drives' rotors. Do not
            change it.
        chains: the legs' kinematics, the base at rest.
        legs, arms: in the order of the file.
        joint_names: (J,) Pinocchio's order, without the root.
        posture: (nq,) default posture, Pinocchio's convention (quaternion x, y, z, w).
        mass, com, inertia: kg, (3,) m, (3, 3) kg m2 about the CoM; world frame, default posture.
        feet: (L, 3) m, contact points of point feet, middles of soles; base_position: (3,) m:
            origin of the root link.
        foot_lift: m, of the feet's frames above what they stand on: of a ball its radius, where the
            frame is its middle; of soles nothing. Plans take it for the same in all postures.
        load_fit: fits the leg maps, or takes them from the cache.
        turns_over: whether it is as the file's [turning] has it.
        drive_strength, battery: shares of the file's torque and speed that its drives give.
        rated: the same robot with the file's drives; None: this is it.
    """

    file: RobotFile
    path: Path
    urdf_path: Path
    urdf_source: Description
    urdf: Description
    model: pin.Model
    chains: LegChains
    legs: tuple[Leg, ...]
    joint_names: tuple[str, ...]
    posture: Array
    mass: float
    com: Array
    inertia: Array
    feet: Array
    base_position: Array
    load_fit: Callable[[Robot], LegFit]
    arms: tuple[Arm, ...] = ()
    foot_lift: float = 0.0
    turns_over: bool = False
    drive_strength: float = 1.0
    battery: float = 1.0
    rated: Robot | None = None

    @property
    def name(self) -> str:
        """Short name."""
        return self.file.name

    @cached_property
    def leg_names(self) -> tuple[str, ...]:
        """(L,) in the order of the file."""
        return tuple(leg.name for leg in self.legs)

    @cached_property
    def hips(self) -> Array:
        """(L, 3) m: hips in the base frame."""
        return np.array([leg.hip for leg in self.legs])

    @cached_property
    def mirrors(self) -> Array:
        """(L, 3) of +1 or -1."""
        return np.array([leg.mirror for leg in self.legs])

    @cached_property
    def leg_joint_index(self) -> IntArray:
        """(L, n): place of each leg's joints among `joint_names`."""
        return np.array([leg.q_index for leg in self.legs]) - 7

    @cached_property
    def arm_joint_index(self) -> IntArray:
        """(A n,): places of the arms' joints among `joint_names`, arm after arm."""
        index = [arm.q_index - 7 for arm in self.arms]
        return np.concatenate(index) if index else np.zeros(0, dtype=np.int64)

    @cached_property
    def arm_angles(self) -> Array:
        """(A n,) rad: of the arms' joints in the default posture, in that order."""
        return self.posture[7:][self.arm_joint_index]

    @cached_property
    def arm_ends(self) -> Array:
        """(2, A n) rad: between which plans move these joints."""
        reach = self.file.arm_reach
        ends = self.joint_stops[:, self.arm_joint_index].copy()
        if reach is None:
            return ends
        both = np.array([reach.lower, reach.upper])
        own = np.hstack([np.sort(both * arm.mirror, axis=0) for arm in self.arms])
        return np.array([np.maximum(ends[0], own[0]), np.minimum(ends[1], own[1])])

    @property
    def base(self) -> pin.Inertia:
        """The root link alone, in its frame."""
        return self.model.inertias[_BASE_JOINT]

    @cached_property
    def trunk(self) -> pin.Inertia:
        """The root link with the arms as they are in the default posture, in its frame."""
        data, q = self.model.createData(), pin.neutral(self.model)
        q[7:] = self.posture[7:]
        pin.ccrba(self.model, data, q, np.zeros(self.model.nv))
        return sum((data.oYcrb[arm.joint_ids[0]] for arm in self.arms), start=self.base)

    @cached_property
    def torque_limit(self) -> Array:
        """(J,) Nm or N that the drives give, in the order of `joint_names`."""
        return self.drive_strength * self.rated_torque

    @cached_property
    def speed_limit(self) -> Array:
        """(J,) rad/s or m/s at which nothing is left, in the order of `joint_names`."""
        return self.battery * self.rated_speed

    @cached_property
    def rated_torque(self) -> Array:
        """(J,) Nm or N: the file's, or the URDF's where the file has none."""
        return self.of_limbs(self.file.limits.torque, None, self.model.effortLimit[6:])

    @cached_property
    def rated_speed(self) -> Array:
        """(J,) rad/s or m/s, likewise."""
        return self.of_limbs(self.file.limits.joint_speed, None, self.model.velocityLimit[6:])

    @cached_property
    def armature(self) -> Array:
        """(J,) kg m2 or kg: the drives' rotors, as the joints feel them."""
        return self._of_drives("armature", ARMATURE_PER_TORQUE * self.rated_torque)

    @cached_property
    def friction(self) -> Array:
        """(J,) Nm or N: the drives' Coulomb friction."""
        return self._of_drives("friction", FRICTION_PER_TORQUE * self.rated_torque)

    @cached_property
    def damping(self) -> Array:
        """(J,) Nm s/rad or N s/m: the drives' viscous friction."""
        most = DAMPING_PER_TORQUE * self.rated_torque
        return self._of_drives("damping", most / self.rated_speed)

    @property
    def drive_delay(self) -> float:
        """From a command until its torque acts, s."""
        delay = self.file.drives.delay
        return DELAY if delay is None else delay

    def of_limbs(self, legs: PerLimb, arms: PerLimb, otherwise: Array) -> Array:
        """(J,) numbers of the joints of legs and of arms; `otherwise` (J,) where there are none."""
        found = otherwise.copy()
        if legs is not None:
            found[self.leg_joint_index] = legs
        if arms is not None and self.arms:
            found[self.arm_joint_index.reshape(len(self.arms), -1)] = arms
        return found

    def _of_drives(self, name: str, assumed: Array) -> Array:
        """(J,) numbers of the file's [drives]; `assumed` where it has none."""
        drives = self.file.drives
        found = self.of_limbs(getattr(drives, name), getattr(drives.arms, name), assumed)
        for joint, own in drives.joints.items():
            if (number := getattr(own, name)) is not None:
                found[self.joint_names.index(joint)] = number
        return found

    @cached_property
    def joint_stops(self) -> Array:
        """(2, J) rad or m: the URDF's lower and upper ends, in the order of `joint_names`."""
        return np.array([self.model.lowerPositionLimit[7:], self.model.upperPositionLimit[7:]])

    @cached_property
    def kept_stops(self) -> Array:
        """(2, J) rad or m: the ends that whole bodies' plans and the controller keep to.

        The robot's own posture is within them.
        """
        return self.stops_kept_by(STOP_MARGIN)

    def stops_kept_by(self, margin: float) -> Array:
        """(2, J) rad or m: the same by another margin, a share of what lies between the stops."""
        (lower, upper), stands = self.joint_stops, self.posture[7:]
        room = margin * (upper - lower)
        return np.array([np.minimum(lower + room, stands), np.maximum(upper - room, stands)])

    @cached_property
    def sliding_joints(self) -> frozenset[str]:
        """Names of the joints that slide; the others turn."""
        sliding = self.leg_joint_index[:, self.chains.prismatic]
        return frozenset(self.joint_names[joint] for joint in sliding.ravel())

    @property
    def foot_coordinates(self) -> int:
        """Coordinates of a foot's place: 3 for points; 4, with its yaw, for lines and soles."""
        return 3 if self.file.foot.is_point else 4

    @cached_property
    def corners(self) -> Array:
        """(c, 3) m: contact points of a foot in its frame, at the height of the sole."""
        return np.array([(x, y, 0.0) for x, y in self.file.foot.corners])

    @cached_property
    def foot_rotation(self) -> Array:
        """(L, 3, 3) R_base_foot in the default posture."""
        angles = self.posture[7:][self.leg_joint_index]
        rotation = self.chains.motion(angles, rotations=True).foot_rotation
        assert rotation is not None
        return rotation

    @cached_property
    def foot_yaw(self) -> Array:
        """(L,) rad: headings of the feet in the default posture."""
        rotation = self.foot_rotation
        return np.arctan2(rotation[:, 1, 0], rotation[:, 0, 0])

    @cached_property
    def turning(self) -> Robot:
        """This robot as its file's [turning] has it, for jumps in which the body turns over. Raises
        `InputError`: the file has no such table.
        """
        if self.turns_over:
            return self
        if self.file.turning is None:
            raise InputError(
                f"{self.name} has no table [turning] in its file, and does no flips or rolls; "
                "expected its reach and timing for a body that turns over"
            )
        rated = None if self.rated is None else self.rated.turning
        return replace(self, file=self.file.turned, turns_over=True, rated=rated)

    @cached_property
    def fit(self) -> LegFit:
        """The fitted leg maps, from the cache if they have been computed before."""
        return self.load_fit(self)

    def __repr__(self) -> str:
        return f"<Robot {self.name}: {self.path}>"

    def parameters(self) -> dict[str, Any]:
        """The numbers that a plan depends on, as plain data for its file."""
        return {
            **self.file.model_dump(mode="json", exclude=_NOT_OF_PLANS),
            "mass": self.mass,
            "com": self.com.tolist(),
            "inertia": self.inertia.tolist(),
            "feet": self.feet.tolist(),
            "foot_lift": self.foot_lift,
            "base_position": self.base_position.tolist(),
            "hips": self.hips.tolist(),
            "mirrors": self.mirrors.tolist(),
            "joint_names": list(self.joint_names),
            "sliding_joints": sorted(self.sliding_joints),
            "armature": self.armature.tolist(),
            "joint_friction": self.friction.tolist(),
            "joint_damping": self.damping.tolist(),
        }

    def control_parameters(self) -> dict[str, Any]:
        """Numbers of the robot file that controller and drives alone have, as plain data."""
        include: Any = {
            **dict.fromkeys(("control", "uncertainty", "drives"), True),
            "limits": {"regeneration"},
        }
        return self.file.model_dump(mode="json", include=include)
