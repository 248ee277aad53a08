"""How the arms of a URDF hang beside the trunk, and how far they may move from there."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin
from scipy.optimize import least_squares

from llsrbm.arrays import Array
from llsrbm.robots.arms import mirror_signs
from llsrbm.robots.draft.anatomy import Anatomy, stops
from llsrbm.robots.placements import subspace
from llsrbm.robots.solids import coal_shape
from llsrbm.robots.urdf import BASE_JOINT

_AHEAD = 0.3  # rad by which the forearm is before the upper arm, which hangs straight down
_OUTWARD = np.arange(0.05, 0.65, 0.05)  # rad likewise, the first that is clear
_CLEAR = 0.01  # m from trunk and legs
_AS_AT_REST = 0.02  # how much a joint that is turned counts, against directions of the arm
_MARGIN = 0.02  # of a joint's range, from its stops
_TWIST, _BEHIND = 1.0, 1.2  # rad: of turns of the upper arm about itself; of arms swung back
_SLANTED = 0.3  # of a unit vector: upper arms that point backwards
_ALONG = 0.9  # cosine, from which on an axis lies along the upper arm
_STEP = 0.05  # rad, by which ends are looked for


def hang(anatomy: Anatomy, posture: Array) -> Array:
    """Angles (2, n) of the arms, which hang beside the trunk with elbows a little bent.

    posture: (nq,) of the legs; arms are as near to the trunk as keeps them clear of all else.
    """
    measure = _clearance(anatomy)
    first = anatomy.arms[0].joint_ids
    for outward in _OUTWARD:
        angles = _solved(anatomy, float(outward))
        if measure(_with_first_arm(anatomy, posture, angles)) > _CLEAR:
            break
    model = anatomy.model
    return np.array([angles * mirror_signs(model, [*first], [*a.joint_ids]) for a in anatomy.arms])


def ends(anatomy: Anatomy, posture: Array) -> tuple[Array, Array]:
    """Lowest and highest angles (n,) of the first arm.

    From the default posture (nq,) each joint alone goes nearly to its stop, or to where the arm
    would meet the trunk or a leg, or is behind the back; a joint that twists the arm not far.
    """
    model, measure = anatomy.model, _clearance(anatomy)
    joints = anatomy.arms[0].joint_ids
    low, high = stops(model, joints)
    margin = _MARGIN * (high - low)
    index = anatomy.index(joints)
    hanging = posture[index]
    found = [np.minimum(low + margin, hanging), np.maximum(high - margin, hanging)]
    for place, rest in enumerate(hanging):
        if _along_the_arm(anatomy, hanging, place):
            found[0][place] = max(found[0][place], rest - _TWIST)
            found[1][place] = min(found[1][place], rest + _TWIST)
        for side in found:
            for angle in np.arange(rest, side[place], np.copysign(_STEP, side[place] - rest)):
                q = posture.copy()
                q[index[place]] = angle
                elbow = _upper_arm(anatomy, q[index])
                behind = elbow[0] < -_SLANTED and elbow[2] > -np.cos(_BEHIND)
                if measure(q) < 0 or behind:
                    side[place] = angle
                    break
    return found[0], found[1]


def _with_first_arm(anatomy: Anatomy, posture: Array, angles: Array) -> Array:
    q = posture.copy()
    q[anatomy.index(anatomy.arms[0].joint_ids)] = angles
    return q


def _solved(anatomy: Anatomy, outward: float) -> Array:
    """(n,) angles of the first arm, which hangs that much (rad) away from the trunk."""
    joints = anatomy.arms[0].joint_ids
    last = joints[-1]
    lever = anatomy.model.inertias[last].lever
    lower, upper = stops(anatomy.model, joints)
    rest = np.clip(0.0, lower, upper)
    side = np.sign(_placed(anatomy, rest).oMi[last].translation[1])
    down = np.array([0.0, side * np.sin(outward), -np.cos(outward)])
    bent = np.cos(_AHEAD) * down + [np.sin(_AHEAD), 0.0, 0.0]

    def residual(q: Array) -> Array:
        forearm = _unit(_placed(anatomy, q).oMi[last].rotation @ lever)
        upper_arm = _upper_arm(anatomy, q)
        return np.concatenate([upper_arm - down, forearm - bent, _AS_AT_REST * (q - rest)])

    generator = np.random.default_rng(0)
    starts = [rest, *generator.uniform(lower, upper, (12, len(rest)))]
    solved = [
        least_squares(residual, start, bounds=(lower - 1e-9, upper + 1e-9)) for start in starts
    ]
    return min(solved, key=lambda result: float(result.cost)).x


def _upper_arm(anatomy: Anatomy, angles: Array) -> Array:
    """(3,) direction from the first arm's shoulder to its elbow, base axes."""
    data, joints = _placed(anatomy, angles), anatomy.arms[0].joint_ids
    return _unit(data.oMi[joints[-1]].translation - data.oMi[joints[1]].translation)


def _along_the_arm(anatomy: Anatomy, angles: Array, place: int) -> bool:
    """True if a joint of the first arm turns the upper arm about itself."""
    model, joint = anatomy.model, anatomy.arms[0].joint_ids[place]
    data = _placed(anatomy, angles)
    axis = subspace(model.joints[joint])[1]
    return bool(abs(data.oMi[joint].rotation @ axis @ _upper_arm(anatomy, angles)) > _ALONG)


def _placed(anatomy: Anatomy, angles: Array) -> pin.Data:
    data = anatomy.model.createData()
    q = _with_first_arm(anatomy, pin.neutral(anatomy.model), angles)
    pin.forwardKinematics(anatomy.model, data, q)
    return data


def _unit(vector: Array) -> Array:
    return vector / max(float(np.linalg.norm(vector)), 1e-9)


def _clearance(anatomy: Anatomy) -> Callable[[Array], float]:
    """Distance (m) of the first arm from trunk and legs in a posture (nq,), by their hulls.

    Of the upper arm and what is beyond it: a shoulder lies within the trunk's hull.
    """
    model = anatomy.model
    arm = anatomy.arms[0].joint_ids[2:]
    others = {BASE_JOINT, *(joint for leg in anatomy.joint_ids for joint in leg)}
    geometry = pin.GeometryModel()
    for shape in anatomy.shapes:
        if shape.joint in others | {*arm}:
            name = f"{shape.link}/{geometry.ngeoms}"
            geometry.addGeometryObject(
                pin.GeometryObject(name, shape.joint, shape.placement, coal_shape(shape))
            )
    joints = [shape.parentJoint for shape in geometry.geometryObjects]
    for one, joint in enumerate(joints):
        for other, against in enumerate(joints):
            if joint in arm and against in others:
                geometry.addCollisionPair(pin.CollisionPair(one, other))
    data, placed = model.createData(), geometry.createData()

    def measure(q: Array) -> float:
        pin.updateGeometryPlacements(model, data, geometry, placed, q)
        pairs = range(len(geometry.collisionPairs))
        return min(
            (pin.computeDistance(geometry, placed, pair).min_distance for pair in pairs),
            default=np.inf,
        )

    return measure
