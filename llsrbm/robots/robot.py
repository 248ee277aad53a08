"""`Robot`: a robot file together with everything computed from its URDF."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.errors import InputError
from llsrbm.robots.adapted_urdf import adapted_urdf
from llsrbm.robots.legs import LegChains, solve_legs
from llsrbm.robots.schema import RobotFile, read_robot_file
from llsrbm.robots.soles import check_soles
from llsrbm.robots.urdf import (
    BASE_JOINT,
    check_joints,
    find_urdf,
    frame_id,
    joint_chain,
    load_model,
)

if TYPE_CHECKING:
    from llsrbm.robots.leg_fit import LegFit

Array = NDArray[np.float64]

# What of a robot file no plan depends on.
_NOT_OF_PLANS: Any = {
    **dict.fromkeys(("control", "uncertainty", "example"), True),
    "turning": {"axes": True},
}
_SYMMETRIC_HIPS = 5e-3  # m; hips that agree this well are taken as exact mirror images.


@dataclass(frozen=True, eq=False)
class Leg:
    """One leg, base outwards: n joints.

    Attributes:
        name: as in the robot file.
        foot_frame, foot_frame_id: the contact point's frame, and its index in `Robot.model`.
        joints, joint_ids: names of the joints, and their indices in `Robot.model`.
        q_index, v_index: (n,) where they stand in Pinocchio's q and v.
        hip: (3,) m: origin of the file's hip joint at zero joint angles, base frame.
        mirror: (3,) of +1 or -1: diag(mirror) maps this leg onto the reference leg.
    """

    name: str
    foot_frame: str
    foot_frame_id: int
    joints: tuple[str, ...]
    joint_ids: tuple[int, ...]
    q_index: NDArray[np.int64]
    v_index: NDArray[np.int64]
    hip: Array
    mirror: Array


@dataclass(frozen=True, eq=False)
class Robot:
    """A robot as the rest of the library sees it: L legs, J joints.

    The default posture stands level on the ground, the lowest foot at z = 0, the CoM above the
    world's origin; soles lie flat, the CoM above what they span.

    Attributes:
        file: the robot file's content; path: where it lies.
        urdf_path: the URDF, with the file's held joints fixed and its frames added.
        urdf_source: the URDF that the file names; without such tables the same.
        package_dirs: where `package://` names in it are looked up.
        model: Pinocchio model with a free flyer at the root link. Do not change it.
        chains: the legs' kinematics, the base at rest.
        legs: in the order of the file.
        joint_names: (J,) Pinocchio's order, without the root.
        posture: (nq,) default posture, Pinocchio's convention (quaternion x, y, z, w).
        mass: kg.
        com: (3,) m, world frame, default posture; also inertia, feet, base_position.
        inertia: (3, 3) kg m2 about the CoM.
        feet: (L, 3) m.
        base_position: (3,) m: origin of the root link.
        turns_over: whether it is as the file's [turning] has it.
    """

    file: RobotFile
    path: Path
    urdf_path: Path
    urdf_source: Path
    package_dirs: tuple[Path, ...]
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
    turns_over: bool = False

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
    def leg_joint_index(self) -> NDArray[np.int64]:
        """(L, n): place of each leg's joints among `joint_names`."""
        return np.array([leg.q_index for leg in self.legs]) - 7

    @cached_property
    def torque_limit(self) -> Array:
        """(J,) Nm or N, in the order of `joint_names`; the URDF's where the file has none."""
        return self._of_joints(self.file.limits.torque, self.model.effortLimit)

    @cached_property
    def speed_limit(self) -> Array:
        """(J,) rad/s or m/s, in the order of `joint_names`; the URDF's where the file has none."""
        return self._of_joints(self.file.limits.joint_speed, self.model.velocityLimit)

    @cached_property
    def sliding_joints(self) -> frozenset[str]:
        """Names of the joints that slide; the others turn."""
        sliding = self.leg_joint_index[:, self.chains.prismatic]
        return frozenset(self.joint_names[joint] for joint in sliding.ravel())

    def _of_joints(self, limit: float | tuple[float, ...] | None, urdf: Array) -> Array:
        if limit is None:
            return np.array(urdf[6:])
        joints = np.empty(len(self.joint_names))
        joints[self.leg_joint_index] = limit
        return joints

    @property
    def foot_coordinates(self) -> int:
        """What describes a foot's place: 3 for points; 4, with its yaw, for lines and soles."""
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
        """This robot as its file's [turning] has it, for jumps in which the body turns over.

        Raises:
            InputError: the file has no such table.
        """
        if self.turns_over:
            return self
        table = self.file.turning
        if table is None:
            raise InputError(
                f"{self.name} has no table [turning] in its file, and does no flips or rolls; "
                "expected its reach and timing for a body that turns over"
            )
        shares = {
            name: share
            for name in ("torque_share", "speed_share")
            if (share := getattr(table, name)) is not None
        }
        changed = {
            "reach": table.reach,
            "timing": table.timing,
            "limits": self.file.limits.model_copy(update=shares),
        }
        return replace(self, file=self.file.model_copy(update=changed), turns_over=True)

    @cached_property
    def fit(self) -> LegFit:
        """The fitted leg maps, from the cache if they have been computed before."""
        from llsrbm.robots.leg_fit import load_or_fit

        return load_or_fit(self)

    def parameters(self) -> dict[str, Any]:
        """The numbers that a plan depends on, as plain data for its file."""
        return {
            **self.file.model_dump(mode="json", exclude=_NOT_OF_PLANS),
            "mass": self.mass,
            "com": self.com.tolist(),
            "inertia": self.inertia.tolist(),
            "feet": self.feet.tolist(),
            "base_position": self.base_position.tolist(),
            "hips": self.hips.tolist(),
            "mirrors": self.mirrors.tolist(),
            "joint_names": list(self.joint_names),
            "sliding_joints": sorted(self.sliding_joints),
        }

    def control_parameters(self) -> dict[str, Any]:
        """What the controller takes from the robot file, defaults included, as plain data."""
        return self.file.model_dump(mode="json", include={"control", "uncertainty"})


def build_robot(path: str | Path) -> Robot:
    """Read a robot file and compute everything from its URDF.

    Raises:
        RobotFileError: the file is wrong in itself, names what its URDF does not have, or its
            default posture does not stand on its soles.
    """
    path = Path(path).resolve()
    file = read_robot_file(path)
    urdf_source, package_dirs = find_urdf(file, path)
    feet = {name: spec.foot for name, spec in file.legs.items()}
    urdf_path, package_dirs = adapted_urdf(urdf_source, package_dirs, file.urdf, feet, path)
    model = load_model(urdf_path, path)
    chains_of = {name: joint_chain(model, file, path, name) for name in file.legs}
    check_joints(model, file, path, chains_of)
    joint_ids = list(chains_of.values())
    foot_ids = [frame_id(model, spec.foot) for spec in file.legs.values()]
    chains = LegChains(model, np.array(joint_ids), tuple(foot_ids))

    posture = pin.neutral(model)
    for name, chain in chains_of.items():
        posture[[model.joints[j].idx_q for j in chain]] = file.posture[name]
    data = model.createData()
    pin.forwardKinematics(model, data, posture)
    pin.updateFramePlacements(model, data)
    lowest = min(data.oMf[f].translation[2] for f in foot_ids)
    com = pin.centerOfMass(model, data, posture)
    posture[:3] = -com[0], -com[1], -lowest
    pin.ccrba(model, data, posture, np.zeros(model.nv))
    pin.updateFramePlacements(model, data)

    neutral = model.createData()
    pin.forwardKinematics(model, neutral, pin.neutral(model))
    hip_ids = [model.getJointId(spec.hip) for spec in file.legs.values()]
    hips = _symmetrised(np.array([neutral.oMi[j].translation for j in hip_ids]))
    angles = np.array([file.posture[name] for name in file.legs])
    mirrors = _mirrors(chains, hips, angles)

    robot = Robot(
        file=file,
        path=path,
        urdf_path=urdf_path,
        urdf_source=urdf_source,
        package_dirs=package_dirs,
        model=model,
        chains=chains,
        legs=tuple(
            Leg(
                name=name,
                foot_frame=spec.foot,
                foot_frame_id=foot_ids[i],
                joints=tuple(model.names[j] for j in joint_ids[i]),
                joint_ids=tuple(joint_ids[i]),
                q_index=np.array([model.joints[j].idx_q for j in joint_ids[i]]),
                v_index=np.array([model.joints[j].idx_v for j in joint_ids[i]]),
                hip=hips[i],
                mirror=mirrors[i],
            )
            for i, (name, spec) in enumerate(file.legs.items())
        ),
        joint_names=tuple(model.names[BASE_JOINT + 1 :]),
        posture=posture,
        mass=float(data.Ig.mass),
        com=data.com[0].copy(),
        inertia=data.Ig.inertia.copy(),
        feet=np.array([data.oMf[f].translation for f in foot_ids]),
        base_position=posture[:3].copy(),
    )
    if robot.foot_coordinates > 3:
        check_soles(robot)
    return robot


def _symmetrised(hips: Array) -> Array:
    """Hips as exact mirror images of one another, if the URDF's are so within rounding."""
    size = np.abs(hips)
    if np.ptp(size[:, :2], axis=0).max() > _SYMMETRIC_HIPS or np.ptp(hips[:, 2]) > _SYMMETRIC_HIPS:
        return hips
    mean = np.append(size[:, :2].mean(axis=0), hips[:, 2].mean())
    sign = np.column_stack([np.sign(hips[:, :2]), np.ones(len(hips))])
    return np.where(sign == 0, hips, sign * mean)


def _mirrors(chains: LegChains, hips: Array, angles: Array) -> Array:
    """(L, 3): the reflection that maps each leg onto the first, seen from its hip.

    Left and right legs mirror each other in y. A hind leg mirrors a front leg in x only if it
    bends the other way (ANYmal's knees point at each other, Go2's all point backward), which its
    CoM tells when feet are put at mirrored places.
    """
    side = np.where(hips[:, 1] < 0, -1.0, 1.0)
    end = np.where(hips[:, 0] * hips[0, 0] < 0, -1.0, 1.0)
    if (end > 0).all():
        return np.column_stack([np.ones(len(hips)), side, np.ones(len(hips))])
    standing = chains.motion(angles).foot - hips
    offsets = 0.12 * np.linalg.norm(standing[0]) * _CORNERS
    front = 1.0 if hips[0, 0] > 0 else -1.0

    def com_map(sign: Array) -> tuple[Array, Array]:
        """CoM (S, L, 3) in the mirrored hip frame, feet where the first leg has them, and error."""
        mirror = np.column_stack([sign, side, np.ones(len(hips))])
        target = mirror * (mirror[0] * standing[0] + offsets[:, None, :]) + hips
        q, error = solve_legs(chains, target, angles)
        return mirror * (chains.masses(q).com - hips), error

    mirrored, mirrored_error = com_map(front * end)
    same, same_error = com_map(np.full(len(hips), front))
    sign = []
    for leg in range(len(hips)):
        reference = mirrored[:, 0]
        as_mirrored = np.abs(mirrored[:, leg] - reference).max() + mirrored_error[:, leg].max()
        as_same = np.abs(same[:, leg] - same[:, 0]).max() + same_error[:, leg].max()
        sign.append(front * end[leg] if as_mirrored <= as_same else front)
    return np.column_stack([sign, side, np.ones(len(hips))])


_CORNERS: Array = np.array(
    [[0, 0, 0], *[[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (0, 1)]]
)
