"""Shapes of links that are near each other in a posture, and how joints move them apart.

Of those of two legs, or of a leg and the base, the pair that joints would bring together soonest
stands for all.
"""

from __future__ import annotations

from dataclasses import dataclass

import coal
import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.robots.link_shapes import LinkShapes
from llsrbm.robots.robot import Robot


@dataclass(frozen=True, eq=False)
class Near:
    """Two shapes near each other.

    Attributes:
        pair: place in `LinkShapes.pairs`; distance: m, negative inside each other.
        slope: (J,) m per rad or m, its derivatives by the joints.
        joints: Pinocchio's of the two; points: (2, 3) m of them, nearest to each other; normal:
            (3,) from the one to the other; both in the world.
    """

    pair: int
    distance: float
    slope: Array
    joints: tuple[int, int]
    points: Array
    normal: Array

    @property
    def turn(self) -> float:
        """Smallest joint step that closes the gap, rad or m."""
        return self.distance / float(np.linalg.norm(self.slope))

    def acceleration(self, data: pin.Data) -> float:
        """m/s2 of the distance while the joints do not accelerate, of points fixed to the links.

        `data`: with the bodies' velocities, and accelerations of joints that do not accelerate.
        """
        first, second = (
            _acceleration(data, joint, point)
            for joint, point in zip(self.joints, self.points, strict=True)
        )
        return float(self.normal @ (second - first))


class NearLinks:
    """Measures a robot's links that can meet, posture by posture.

    A pair that was measured cannot have come nearer than joints have moved its links since: while
    postures follow each other closely, few have to be measured again.
    """

    def __init__(self, shapes: LinkShapes) -> None:
        self._model, self.shapes = shapes.robot.model, shapes
        self._geometry = shapes.geometry
        self._placed = self._geometry.createData()
        pairs = np.reshape(np.array(shapes.shape_pairs, dtype=np.int64), (-1, 2))
        reach = _reach(shapes)
        self._pairs = pairs.tolist()
        self._reach = reach[pairs[:, 0]] + reach[pairs[:, 1]]
        self._measured = np.full(len(pairs), -np.inf)  # m, and with which joints
        self._joints = np.zeros_like(self._reach)
        robot = shapes.robot
        limb_of = {
            joint: place
            for place, limb in enumerate((*robot.legs, *robot.arms))
            for joint in limb.joint_ids
        }
        limbs = [limb_of.get(shape.joint, -1) for shape in shapes.shapes]
        self._limbs = [(limbs[one], limbs[other]) for one, other in self._pairs]

    @classmethod
    def of(cls, robot: Robot) -> NearLinks:
        """A robot's, with storage of its own. Raises what `LinkShapes.of` raises."""
        return cls(LinkShapes.of(robot))

    def at(self, data: pin.Data, q: Array, within: Array) -> list[Near]:
        """Those `within` (K,) m of each other that joints move, by soonest, in a posture q (nq,).

        `data`: with its bodies placed, and the joints' Jacobians.
        """
        joints = q[7:]
        least = self._measured - (self._reach * np.abs(joints - self._joints)).sum(axis=1)
        candidates = np.flatnonzero(least < within).tolist()
        if not candidates:
            return []
        self._joints[candidates] = joints
        pin.updateGeometryPlacements(self._model, data, self._geometry, self._placed)
        known: dict[tuple[int, int], Near] = {}
        for k in candidates:
            found = pin.computeDistance(self._geometry, self._placed, k)
            self._measured[k] = found.min_distance
            if found.min_distance < within[k]:
                near, limbs = self._near(data, k, found), self._limbs[k]
                if not near.slope.any():
                    continue
                if limbs not in known or near.turn < known[limbs].turn:
                    known[limbs] = near
        return sorted(known.values(), key=lambda near: near.turn)

    def within(self, distance: float) -> Array:
        """(K,) m, one distance for all pairs."""
        return np.full(len(self._pairs), distance)

    def fastest(self, v: Array) -> Array:
        """(K,) m/s: how fast joints move the links of each pair against each other, at most."""
        return self._reach @ np.abs(v[6:])

    def _near(self, data: pin.Data, pair: int, found: coal.DistanceResult) -> Near:
        shapes, (one, other) = self.shapes.shapes, self._pairs[pair]
        joints = (shapes[one].joint, shapes[other].joint)
        points = np.array([found.getNearestPoint1(), found.getNearestPoint2()])
        along = [
            _along(self._model, data, joint, point, found)
            for joint, point in zip(joints, points, strict=True)
        ]
        normal = np.array(found.normal)
        slope = (along[1] - along[0])[6:]
        place = int(self.shapes.pair_of[pair])
        return Near(place, found.min_distance, slope, joints, points, normal)


def away_from(
    shapes: LinkShapes,
    data: pin.Data,
    shape: coal.ShapeBase,
    placement: pin.SE3,
    bounds: Array,
    within: float,
) -> tuple[float, Array]:
    """The link nearest to a shape in the world, feet aside.

    `data`: with the bodies placed, and the joints' Jacobians; `bounds`: (S,) m of `least_from`.

    Returns:
        its distance, m, negative inside, infinite if none is `within` (m); (nv,) its derivatives by
        Pinocchio's velocities.
    """
    found, joint = shapes.nearest_to(shape, placement, data, bounds, within)
    if found.min_distance >= within:
        return np.inf, np.zeros(shapes.robot.model.nv)
    slope = -_along(shapes.robot.model, data, joint, found.getNearestPoint1(), found)
    return float(found.min_distance), slope


def _along(
    model: pin.Model, data: pin.Data, joint: int, point: Array, found: coal.DistanceResult
) -> Array:
    """(nv,) how fast a point of a body moves along the normal: the power of a unit force there."""
    normal = np.array(found.normal)
    wrench = np.concatenate([normal, pin.skew(np.array(point)).dot(normal)])
    return wrench.dot(pin.getJointJacobian(model, data, joint, pin.ReferenceFrame.WORLD))


def _reach(shapes: LinkShapes) -> Array:
    """(S, J) m per rad or m: by how much each joint moves any point of a shape at most."""
    model = shapes.robot.model
    slides = {model.getJointId(name) for name in shapes.robot.sliding_joints}
    travel = np.maximum(np.abs(model.lowerPositionLimit), np.abs(model.upperPositionLimit))
    centres, radii = shapes.spheres
    reach = np.zeros((len(radii), model.nv - 6))
    for place, shape in enumerate(shapes.shapes):
        far = float(np.linalg.norm(centres[place])) + float(radii[place])  # from the joint's origin
        joint = shape.joint
        while joint > 1:
            index = model.joints[joint].idx_v - 6
            reach[place, index] = 1.0 if joint in slides else far
            far += float(np.linalg.norm(model.jointPlacements[joint].translation))
            far += float(travel[index + 7]) if joint in slides else 0.0
            joint = model.parents[joint]
    return reach


def _acceleration(data: pin.Data, joint: int, point: Array) -> Array:
    """(3,) m/s2 of a point (3,) m of a body, world frame."""
    placement, velocity, acceleration = data.oMi[joint], data.v[joint], data.a[joint]
    arm, turn = placement.actInv(point), pin.skew(velocity.angular)
    moves = velocity.linear + turn.dot(arm)
    turns = pin.skew(acceleration.angular).dot(arm) + turn.dot(moves)
    return placement.rotation.dot(acceleration.linear + turns)
