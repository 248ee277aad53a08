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
from llsrbm.robots.legs import LegChains
from llsrbm.robots.placements import subspace
from llsrbm.robots.schema import AddedFrame, UrdfSource
from llsrbm.robots.solids import PlacedSolid, placed_solids
from llsrbm.robots.urdf import BASE_JOINT, bodies_on, check_moving, frame_id, pinocchio_model

_FOOT = re.compile(r"foot|sole|toe|ankle|contact", re.IGNORECASE)
_SOLE = re.compile(r"sole|foot", re.IGNORECASE)
_JOINTS_OF_A_LEG = (3, 6)  # of point feet; of soles, whose attitude matters too
_ACROSS = 0.7  # component along y from which on an axis is one about which a leg swings forward


_CORNERS = 4  # of a sole
_OFF_THE_MIDDLE = 0.01  # m from a sole's frame to the middle of the sole on the ground
_TURNED = 1e-3  # rad, likewise
_UPRIGHT = 0.5  # rad by which a frame that may be a sole's is turned with all joints at zero
_EVEN = 2e-3  # m from a sole's lowest point within which the ground touches it
_AT_JOINT = 0.02  # m from a leg's last joint to a frame that is not at its foot
_AS_LOW = 0.01  # m from the end of a leg up to which another chain may be one as well
_SAME_END = 0.005  # m by which corners of a shank's end may differ in their distance
_BALL = 0.02  # m, radius of a foot's ball where nothing tells


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
    corners, radius = _contact_points(
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
            frame, name = _middle_of_sole(model, data, foot, shapes, where), f"{leg}_sole"
        elif np.linalg.norm(model.frames[frame_id(model, foot)].placement.translation) < _AT_JOINT:
            drawn = [*shapes, *placed_solids(robot, model, "visuals")]
            frame, name = _end_of_leg(model, joints[-1], foot, drawn, where), f"{leg}_foot"
        if frame is not None:
            foot = _new_name(name, model)
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
        end = end * (1 - _BALL / max(float(np.linalg.norm(end)), 2 * _BALL))
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


def _middle_of_sole(
    model: pin.Model, data: pin.Data, foot: str, shapes: list[PlacedSolid], where: str
) -> AddedFrame | None:
    """Where the frame of a sole belongs, seen from the link at the end of its leg; None: there.

    With all joints at zero soles are level and point forward, unless the shapes lie flat on the
    ground in the frame that the URDF has there, and not so.
    """
    frame = model.frames[frame_id(model, foot)]
    on = [shape for shape in shapes if shape.joint == frame.parentJoint]
    if not on:
        raise RobotFileError(
            f"{where}: the link that carries {foot} has no collision geometry; expected some "
            "there, for its sole is measured from it"
        )
    rotation = data.oMi[frame.parentJoint].rotation.T  # of base axes against the joint's
    rpy = pin.rpy.matrixToRpy(frame.placement.rotation.T @ rotation)
    turned = bool(np.abs(rpy).max() > _TURNED)
    straight = pin.SE3(rotation, frame.placement.translation)
    if turned and np.linalg.norm(pin.log3(pin.rpy.rpyToMatrix(rpy))) < _UPRIGHT:
        turned = _lies_flat(straight, on) or not _lies_flat(frame.placement, on)
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


def _lies_flat(frame: pin.SE3, shapes: list[PlacedSolid]) -> bool:
    """Whether ground across the frame's z axis touches half of the shapes, along and across."""
    points = _corners_of(frame, shapes)
    touching = points[points[:, 2] < points[:, 2].min() + _EVEN]
    return bool((np.ptp(touching[:, :2], axis=0) > np.ptp(points[:, :2], axis=0) / 2).all())


def _new_name(name: str, model: pin.Model) -> str:
    while any(model.existFrame(taken) for taken in (name, f"{name}_fixed")):
        name += "_middle"
    return name


def _contact_points(
    frame: pin.Frame, shapes: list[PlacedSolid], *, sole: bool
) -> tuple[tuple[tuple[float, float], ...], float | None]:
    """Contact points of a foot in its frame, and their radius where the URDF has no spheres."""
    shapes = [shape for shape in shapes if shape.joint == frame.parentJoint]
    spheres = [s for s in shapes if s.is_sphere]
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


def _corners_of(frame: pin.SE3, shapes: list[PlacedSolid]) -> Array:
    """(N, 3) m: corners of the shapes, in a frame that is placed in that of the same joint."""
    inside = frame.inverse()
    points = [shape.corners @ inside.rotation.T + inside.translation for shape in shapes]
    return np.concatenate([np.empty((0, 3)), *points])


def _ball_radius(frame: pin.Frame, shapes: list[PlacedSolid]) -> float:
    """Half of what the shape around a point foot measures neither along nor across it, m.

    Of a capsule, a cylinder and a disc it is the radius, however long or thin they are.
    """
    around = [
        points
        for points in (_corners_of(frame.placement, [shape]) for shape in shapes)
        if (points.min(axis=0) - 1e-3 <= 0).all() and (points.max(axis=0) + 1e-3 >= 0).all()
    ]
    if not around:
        return _BALL
    smallest = min(around, key=lambda points: float(np.ptp(points, axis=0).max()))
    return round(float(np.clip(np.median(np.ptp(smallest, axis=0)) / 2, 0.005, 0.04)), 4)
