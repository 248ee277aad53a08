"""The limbs of a URDF: their chains and ends, and contacts of the legs with the ground."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.errors import RobotFileError
from llsrbm.robots.description import Description, changed, read_description
from llsrbm.robots.draft.arms import ArmAnatomy, arm_anatomy, arm_joints
from llsrbm.robots.draft.feet import BALL, contact_points, middle_of_sole, new_name
from llsrbm.robots.legs import LegChains
from llsrbm.robots.placements import subspace
from llsrbm.robots.schema import AddedFrame, UrdfSource
from llsrbm.robots.solids import PlacedSolid, placed_solids
from llsrbm.robots.urdf import BASE_JOINT, bodies_on, check_moving, frame_id, pinocchio_model

_FOOT = re.compile(r"foot|sole|toe|ankle|contact", re.IGNORECASE)
_SOLE = re.compile(r"sole|foot", re.IGNORECASE)
_JOINTS_OF_A_LEG = (3, 6)  # of point feet; of soles, whose attitude matters too
_ACROSS = 0.7  # component along y from which on an axis is one about which a leg swings forward
_AT_JOINT = 0.02  # m from a leg's last joint to a frame that is not at its foot
_AS_LOW = 0.01  # m from the end of a leg up to which another chain may be one as well
_SAME_END = 0.005  # m by which corners of a shank's end may differ in their distance


@dataclass(frozen=True, eq=False)
class Anatomy:
    """L legs of n joints and two arms or none, as the URDF has them with all other joints held.

    Attributes:
        urdf, source: the file as it is, and what it says.
        model: Pinocchio's, with joints held and frames added.
        held, frames: these, as in a robot file's table [urdf].
        arms: the left and the right one.
        shapes: the URDF's collision geometry.
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
    source: Description
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
    arms: tuple[ArmAnatomy, ...]
    shapes: list[PlacedSolid]
    held: dict[str, float] = field(default_factory=dict)
    frames: dict[str, AddedFrame] = field(default_factory=dict)

    @property
    def has_soles(self) -> bool:
        """True if the feet have a direction."""
        return len(self.corners) > 1

    @property
    def mass(self) -> float:
        """Total mass (kg)."""
        return float(pin.computeTotalMass(self.model))

    def index(self, joints: Iterable[int]) -> list[int]:
        """Places of joints in a posture q (nq,)."""
        return [self.model.joints[joint].idx_q for joint in joints]


def read_anatomy(urdf: Path) -> Anatomy:
    """Find the legs of a URDF. Raises `RobotFileError`: it is no URDF, or none of a robot with legs
    of their own joints.
    """
    where = str(urdf)
    source = read_description(urdf, where)
    model = pinocchio_model(source, where)
    legs, spare = _legs(model, urdf)
    arms = arm_joints(model, spare)
    free = {joint for arm in arms for joint in arm}
    held = _held(source, [model.names[j] for j in spare if model.names[j] not in free])
    change = UrdfSource(file=urdf.name, held=held)
    robot = changed(source, change, {}, where)
    model = pinocchio_model(robot, where)
    check_moving(robot, model, where)
    joints = [[model.getJointId(name) for name in leg] for leg in legs]
    data = _at_zero(model)
    order, names = _named(np.array([data.oMi[leg[-1]].translation for leg in joints]))
    joints = [joints[k] for k in order]
    shapes = placed_solids(robot, model, "collisions")
    feet, frames = _feet(robot, model, data, dict(zip(names, joints, strict=True)), shapes, where)
    if frames:
        change = UrdfSource(file=urdf.name, held=held, frames=frames)
        robot = changed(source, change, {}, where)
        model = pinocchio_model(robot, where)
        data = _at_zero(model)
        shapes = placed_solids(robot, model, "collisions")
    foot_ids = [frame_id(model, foot) for foot in feet]
    hips = [_hip(model, data, leg, urdf) for leg in joints]
    lower, upper = zip(*(stops(model, leg) for leg in joints), strict=True)
    corners, radius = contact_points(
        model.frames[foot_ids[0]], shapes, sole=len(joints[0]) > _JOINTS_OF_A_LEG[0]
    )
    return Anatomy(
        urdf=urdf,
        source=source,
        model=model,
        names=names,
        feet=tuple(feet),
        hips=tuple(model.names[hip] for hip in hips),
        joint_ids=tuple(tuple(leg) for leg in joints),
        chains=LegChains(model, np.array(joints), tuple(foot_ids)),
        hip_position=np.array([data.oMi[hip].translation for hip in hips]),
        lower=np.array(lower),
        upper=np.array(upper),
        corners=corners,
        radius=radius,
        arms=arm_anatomy(model, arms),
        shapes=shapes,
        held=change.held,
        frames=change.frames,
    )


def stops(model: pin.Model, joints: Sequence[int]) -> tuple[Array, Array]:
    """Lowest and highest angles (n,) of joints, rad or m; at most half a turn either way."""
    at = [model.joints[joint].idx_q for joint in joints]
    lower, upper = model.lowerPositionLimit[at], model.upperPositionLimit[at]
    return np.maximum(lower, -np.pi), np.minimum(upper, np.pi)


def _held(robot: Description, names: list[str]) -> dict[str, float]:
    """Angles of joints to hold: zero, or where their limits allow next to it; of those that mimic
    others what these make of them.
    """
    held = {}
    for name in names:
        joint = robot.joints[name]
        limit = joint.limit
        held[name] = 0.0
        if limit is not None and joint.kind != "continuous":
            held[name] = round(float(np.clip(0.0, limit.lower, limit.upper)), 4) + 0.0
    for _ in names:  # of chains of joints that mimic each other the first are right first
        for name in names:
            mimic = robot.joints[name].mimic
            if mimic is not None and mimic.joint in held:
                held[name] = mimic.multiplier * held[mimic.joint] + mimic.offset
    return held


def _feet(
    robot: Description,
    model: pin.Model,
    data: pin.Data,
    legs: dict[str, list[int]],
    shapes: list[PlacedSolid],
    where: str,
) -> tuple[list[str], dict[str, AddedFrame]]:
    """Names of the feet's frames in the order of the legs, and those that the URDF lacks."""
    feet, frames = [], {}
    for leg, joints in legs.items():
        foot, frame = _foot_frame(model, data, joints), None
        if len(joints) > _JOINTS_OF_A_LEG[0]:
            frame, name = middle_of_sole(model, data, foot, shapes, where), f"{leg}_sole"
        elif np.linalg.norm(model.frames[frame_id(model, foot)].placement.translation) < _AT_JOINT:
            drawn = [*shapes, *placed_solids(robot, model, "visuals")]
            frame, name = _end_of_leg(model, joints[-1], foot, drawn, where), f"{leg}_foot"
        if frame is not None:
            foot = new_name(name, model)
            frames[foot] = frame
        feet.append(foot)
    return feet, frames


def _end_of_leg(
    model: pin.Model, joint: int, link: str, solids: list[PlacedSolid], where: str
) -> AddedFrame:
    """Where the ball of a foot is that is merged into a shank, seen from the shank's link."""
    own = [solid for solid in solids if solid.joint == joint]
    balls = [solid.placement.translation for solid in own if solid.is_sphere]
    if not own:
        raise RobotFileError(
            f'{where}: link "{link}" ends a leg and has neither a frame at its foot nor shapes; '
            "expected a link there on a fixed joint"
        )
    points = np.array(balls) if balls else np.concatenate([solid.corners for solid in own])
    far = np.linalg.norm(points, axis=1)
    end = points[far > far.max() - _SAME_END].mean(axis=0)
    if not balls:  # the middle of a ball within the end
        end = end * (1 - BALL / max(float(np.linalg.norm(end)), 2 * BALL))
    x, y, z = model.frames[frame_id(model, link)].placement.actInv(end)
    return AddedFrame(link=link, xyz=(round(x, 4) + 0.0, round(y, 4) + 0.0, round(z, 4) + 0.0))


def _at_zero(model: pin.Model) -> pin.Data:
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    return data


def _legs(model: pin.Model, urdf: Path) -> tuple[list[list[str]], list[int]]:
    """The joints of each leg, from the base outwards, by name; and those of no leg.

    These move no foot or, as a waist that the root is above, all of them.
    """
    joints = range(BASE_JOINT + 1, model.njoints)
    chains = []
    for end in sorted(set(joints) - {model.parents[j] for j in joints}):
        chain = [end]
        while model.parents[chain[0]] > BASE_JOINT:
            chain.insert(0, model.parents[chain[0]])
        chains.append(chain)
    kinds = [
        (
            tuple(model.joints[j].shortname()[:11] for j in chain),
            any(chain[0] == other[0] for other in chains if other is not chain),  # as arms do
        )
        for chain in chains
    ]
    # Legs are what there are most of that is built alike, and of those what reaches lowest.
    data = _at_zero(model)
    heights = {
        kind: np.mean([data.oMi[c[-1]].translation[2] for c, k in zip(chains, kinds) if k == kind])
        for kind in kinds
    }
    alike = min(heights, key=lambda kind: (kinds.count(kind) < 2, heights[kind]))
    legs = [chain for chain, kind in zip(chains, kinds, strict=True) if kind == alike]
    often = {j: sum(j in leg for leg in legs) for leg in legs for j in leg}
    shared = sorted(j for j, times in often.items() if 1 < times < len(legs))
    if shared:
        listed = ", ".join(model.names[j] for j in shared[:8])
        more = f" and {len(shared) - 8} more" if len(shared) > 8 else ""
        some = "joint {} moves" if len(shared) == 1 else "joints {} move"
        raise RobotFileError(
            f"{urdf}: {some.format(listed + more)} some of the feet; expected every joint to move "
            'one foot, none or all: write type="fixed" in place of theirs'
        )
    lowest = max(data.oMi[leg[-1]].translation[2] for leg in legs) + _AS_LOW
    for chain, kind in zip(chains, kinds, strict=True):
        if kind != alike and data.oMi[chain[-1]].translation[2] < lowest:
            raise RobotFileError(
                f"{urdf}: the chain of joints to {model.names[chain[-1]]} reaches as low as the "
                f"leg to {model.names[legs[0][-1]]} and is not built alike; expected all legs "
                "alike, of joints of their own, and z up"
            )
    if len(legs) > 1:
        legs = [[j for j in leg if often[j] == 1] for leg in legs]
    if len(legs) < 2 or len(legs[0]) not in _JOINTS_OF_A_LEG:
        one = "the only chain like a leg has"
        found = one if len(legs) == 1 else f"the {len(legs)} chains most like legs have"
        listed = ", ".join(model.names[j] for j in legs[0])
        raise RobotFileError(
            f"{urdf}: {found} {len(legs[0])} joints ({listed}); expected two legs or more, of 3 "
            "joints (point feet) or 6 (soles)"
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
    bodies = bodies_on(model, leg[-1])
    soles = len(leg) > _JOINTS_OF_A_LEG[0]
    pattern = _SOLE if soles else _FOOT
    named = [frame for frame in bodies if pattern.search(frame.name)] or bodies
    # Of soles the lowest frame is the one on the ground; of balls the outermost is the ball.

    def rank(frame: pin.Frame) -> float:
        if soles:
            return -round(float((data.oMi[leg[-1]] * frame.placement).translation[2]), 4)
        return float(np.linalg.norm(frame.placement.translation))

    return str(max(named, key=rank).name)


def _hip(model: pin.Model, data: pin.Data, leg: list[int], urdf: Path) -> int:
    """The first joint that swings the leg forward, about an axis across the robot."""
    for joint in leg:
        if abs((data.oMi[joint].rotation @ subspace(model.joints[joint])[1])[1]) > _ACROSS:
            return joint
    raise RobotFileError(
        f"{urdf}: no joint of the leg that begins with {model.names[leg[0]]} turns about an axis "
        "across the robot; expected base axes x forward, y left, z up"
    )


# ---- contacts of feet with the ground, by their collision geometry
