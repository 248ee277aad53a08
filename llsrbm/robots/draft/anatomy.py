"""The legs of a URDF: their chains, ends, and contacts with the ground."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.errors import RobotFileError
from llsrbm.robots.adapted_urdf import adapted_urdf
from llsrbm.robots.draft.feet import contact_points, middle_of_sole, new_name
from llsrbm.robots.legs import LegChains
from llsrbm.robots.urdf import BASE_JOINT, collision_geometry, frame_id, load_model
from llsrbm.robots.urdf_table import AddedFrame, UrdfSource

Array = NDArray[np.float64]

_FOOT = re.compile(r"foot|sole|toe|ankle|contact", re.IGNORECASE)
_SOLE = re.compile(r"sole|foot", re.IGNORECASE)
_JOINTS_OF_A_LEG = (3, 6)  # of point feet; of soles, whose attitude matters too
_ACROSS = 0.7  # component along y from which on an axis is one about which a leg swings forward


@dataclass(frozen=True, eq=False)
class Anatomy:
    """L legs of n joints, as the URDF has them with what moves no foot held.

    Attributes:
        urdf: the file as it is; model: Pinocchio's, with joints held and frames added.
        held, frames: these, as in a robot file's table [urdf].
        names: (L,) made from where the feet are: FL, FR, RL, RR; or left, right.
        feet: (L,) names of the feet's frames; hips: (L,) of the joints that swing legs forward.
        joint_ids: (L, n) in the model, from the base outwards.
        chains: their kinematics.
        hip_position: (L, 3) m: origins of the hips at zero joint angles, base frame.
        lower, upper: (L, n) limits of the joints, rad or m; at most a turn.
        corners: x and y, m, of the contact points in the frame of a foot; one for a point foot.
        radius: m, of what touches the ground there; None: the URDF has spheres.
    """

    urdf: Path
    model: pin.Model
    names: tuple[str, ...]
    feet: tuple[str, ...]
    hips: tuple[str, ...]
    joint_ids: tuple[tuple[int, ...], ...]
    chains: LegChains
    hip_position: Array
    lower: Array
    upper: Array
    corners: tuple[tuple[float, float], ...]
    radius: float | None
    held: dict[str, float] = field(default_factory=dict)
    frames: dict[str, AddedFrame] = field(default_factory=dict)

    @property
    def has_soles(self) -> bool:
        """True if the feet have a direction."""
        return len(self.corners) > 1

    @property
    def mass(self) -> float:
        """Kg, of the whole robot."""
        return float(pin.computeTotalMass(self.model))


def read_anatomy(urdf: Path, package_dirs: tuple[Path, ...]) -> Anatomy:
    """Find the legs of a URDF, whose `package://` names are looked up in `package_dirs`.

    Raises:
        RobotFileError: it is no URDF, or none of a robot with legs of their own joints.
    """
    model = load_model(urdf, urdf)
    legs, spare = _legs(model, urdf)
    held = {model.names[joint]: _rest(model, joint) for joint in spare}
    changed = UrdfSource(file=urdf.name, held=held)
    model, path, dirs = _adapted(urdf, package_dirs, changed)
    joints = [[model.getJointId(name) for name in leg] for leg in legs]
    data = _at_zero(model)
    order, names = _named(np.array([data.oMi[leg[-1]].translation for leg in joints]))
    joints = [joints[k] for k in order]
    feet = [_foot_frame(model, data, leg) for leg in joints]
    shapes = collision_geometry(model, path, dirs, urdf)
    if len(joints[0]) > _JOINTS_OF_A_LEG[0]:
        frames = {}
        for k, leg in enumerate(names):
            frame = middle_of_sole(model, data, feet[k], shapes, urdf)
            if frame is not None:
                feet[k] = new_name(f"{leg}_sole", model)
                frames[feet[k]] = frame
        if frames:
            changed = UrdfSource(file=urdf.name, held=held, frames=frames)
            model, path, dirs = _adapted(urdf, package_dirs, changed)
            data = _at_zero(model)
            shapes = collision_geometry(model, path, dirs, urdf)
    foot_ids = [frame_id(model, foot) for foot in feet]
    hips = [_hip(model, data, leg, urdf) for leg in joints]
    at = [[model.joints[j].idx_q for j in leg] for leg in joints]
    corners, radius = contact_points(
        model.frames[foot_ids[0]], shapes, sole=len(joints[0]) > _JOINTS_OF_A_LEG[0]
    )
    return Anatomy(
        urdf=urdf,
        model=model,
        names=names,
        feet=tuple(feet),
        hips=tuple(model.names[hip] for hip in hips),
        joint_ids=tuple(tuple(leg) for leg in joints),
        chains=LegChains(model, np.array(joints), tuple(foot_ids)),
        hip_position=np.array([data.oMi[hip].translation for hip in hips]),
        lower=np.maximum(model.lowerPositionLimit[at], -np.pi),
        upper=np.minimum(model.upperPositionLimit[at], np.pi),
        corners=corners,
        radius=radius,
        held=changed.held,
        frames=changed.frames,
    )


def _adapted(
    urdf: Path, package_dirs: tuple[Path, ...], changed: UrdfSource
) -> tuple[pin.Model, Path, tuple[Path, ...]]:
    """The model with joints held and frames added, the URDF that says so, its packages' folders."""
    path, dirs = adapted_urdf(urdf, package_dirs, changed, {}, urdf)
    return load_model(path, urdf), path, dirs


def _at_zero(model: pin.Model) -> pin.Data:
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    return data


def _rest(model: pin.Model, joint: int) -> float:
    """Zero, or what a joint's limits allow next to it."""
    if model.joints[joint].nq != 1:  # turns without limits
        return 0.0
    at = model.joints[joint].idx_q
    lower, upper = model.lowerPositionLimit[at], model.upperPositionLimit[at]
    return round(float(np.clip(0.0, lower, upper)), 4) + 0.0


def _legs(model: pin.Model, urdf: Path) -> tuple[list[list[str]], list[int]]:
    """The joints of each leg, from the base outwards, by name; and those that move no foot."""
    joints = range(BASE_JOINT + 1, model.njoints)
    chains = []
    for end in sorted(set(joints) - {model.parents[j] for j in joints}):
        chain = [end]
        while model.parents[chain[0]] > BASE_JOINT:
            chain.insert(0, model.parents[chain[0]])
        chains.append(chain)
    kinds = [tuple(model.joints[j].shortname()[:11] for j in chain) for chain in chains]
    # Legs are what there are most of that is built alike, and of those what reaches lowest.
    data = _at_zero(model)
    heights = {
        kind: np.mean([data.oMi[c[-1]].translation[2] for c, k in zip(chains, kinds) if k == kind])
        for kind in kinds
    }
    alike = min(heights, key=lambda kind: (kinds.count(kind) < 2, heights[kind]))
    legs = [chain for chain, kind in zip(chains, kinds, strict=True) if kind == alike]
    shared = sorted({j for leg in legs for j in leg if sum(j in other for other in legs) > 1})
    if shared:
        listed = ", ".join(model.names[j] for j in shared[:8])
        more = f" and {len(shared) - 8} more" if len(shared) > 8 else ""
        raise RobotFileError(
            f"{urdf}: joints {listed}{more} move more than one foot; expected every joint to move "
            'one foot or none: write type="fixed" in place of theirs'
        )
    if len(legs) < 2 or len(legs[0]) not in _JOINTS_OF_A_LEG:
        raise RobotFileError(
            f"{urdf}: found {len(legs)} legs of {len(legs[0])} joints; expected two legs or more, "
            "of 3 joints (point feet) or 6 (soles)"
        )
    spare = sorted(set(joints) - {j for leg in legs for j in leg})
    return [[model.names[j] for j in leg] for leg in legs], spare


def _named(ends: Array) -> tuple[list[int], tuple[str, ...]]:
    """The order of the legs and their names, from where they end, (L, 3) m."""
    left = ends[:, 1] > 0
    if len(ends) == 2:
        return [int(np.argmax(left)), int(np.argmin(left))], ("left", "right")
    if len(ends) == 4:
        front = ends[:, 0] > np.median(ends[:, 0])
        order = sorted(range(4), key=lambda k: (not front[k], not left[k]))
        return order, ("FL", "FR", "RL", "RR")
    order = sorted(range(len(ends)), key=lambda k: (-ends[k, 0], -ends[k, 1]))
    return order, tuple(f"leg{k + 1}" for k in range(len(ends)))


def _foot_frame(model: pin.Model, data: pin.Data, leg: list[int]) -> str:
    """The body at the end of a leg: by its name if it has one, else the farthest from its joint."""
    bodies = [
        frame
        for frame in model.frames
        if frame.parentJoint == leg[-1] and frame.type == pin.FrameType.BODY
    ]
    soles = len(leg) > _JOINTS_OF_A_LEG[0]
    pattern = _SOLE if soles else _FOOT
    named = [frame for frame in bodies if pattern.search(frame.name)] or bodies
    # Of soles the lowest frame is the one on the ground; of balls the outermost is the ball.
    return str(
        max(
            named,
            key=lambda frame: (
                -round(float((data.oMi[leg[-1]] * frame.placement).translation[2]), 4)
                if soles
                else float(np.linalg.norm(frame.placement.translation))
            ),
        ).name
    )


def _hip(model: pin.Model, data: pin.Data, leg: list[int], urdf: Path) -> int:
    """The first joint that swings the leg forward, about an axis across the robot."""
    for joint in leg:
        subspace = np.asarray(model.joints[joint].createData().S).reshape(6)
        if abs((data.oMi[joint].rotation @ subspace[3:])[1]) > _ACROSS:
            return joint
    raise RobotFileError(
        f"{urdf}: no joint of the leg that begins with {model.names[leg[0]]} turns about an axis "
        "across the robot; expected base axes x forward, y left, z up"
    )
