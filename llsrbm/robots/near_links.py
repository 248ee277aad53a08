"""Shapes of links that are near each other in a posture, and how joints move them apart.

Of those of two legs, or of a leg and the base, the pair that joints would bring together soonest
stands for all.
"""

from __future__ import annotations

from dataclasses import dataclass

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.robots.link_shapes import LinkShapes
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Near:
    """Two shapes near each other.

    Attributes:
        distance: m, negative inside each other.
        slope: (J,) m per rad or m, its derivatives by the joints.
        joints: Pinocchio's of the two; points: (2, 3) m of them, nearest to each other; normal:
            (3,) from the one to the other; both in the world.
    """

    distance: float
    slope: Array
    joints: tuple[int, int]
    points: Array
    normal: Array

    @property
    def turn(self) -> float:
        """By which all joints together would bring the two together, rad or m."""
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
    """Measures a robot's links that can meet, posture by posture."""

    def __init__(self, shapes: LinkShapes) -> None:
        self._model, self._shapes = shapes.robot.model, shapes
        self._geometry = shapes.geometry
        self._placed = self._geometry.createData()
        joints = [shape.joint for shape in shapes.shapes]
        self._joints, self._of_shape = np.unique(joints, return_inverse=True)
        self._centres, self._radii = shapes.spheres
        self._one, self._other = np.reshape(np.array(shapes.shape_pairs, dtype=np.int64), (-1, 2)).T
        self._least = self._radii[self._one] + self._radii[self._other]
        limb_of = {
            joint: place for place, leg in enumerate(shapes.robot.legs) for joint in leg.joint_ids
        }
        limbs = np.array([limb_of.get(joint, -1) for joint in joints])
        self._limbs = list(zip(limbs[self._one].tolist(), limbs[self._other].tolist(), strict=True))

    @classmethod
    def of(cls, robot: Robot) -> NearLinks:
        """A robot's, with storage of its own. Raises what `LinkShapes.of` raises."""
        return cls(LinkShapes.of(robot))

    def at(self, data: pin.Data, within: float) -> list[Near]:
        """Those `within` (m) of each other that joints move, by soonest.

        `data`: with the bodies placed, and the joints' Jacobians.
        """
        # Shapes whose spheres are farther apart need not be measured.
        moved = [data.oMi[joint] for joint in self._joints.tolist()]
        rotation = np.array([placement.rotation for placement in moved])[self._of_shape]
        origin = np.array([placement.translation for placement in moved])[self._of_shape]
        centres = origin + np.einsum("sij,sj->si", rotation, self._centres)
        between = centres[self._one] - centres[self._other]
        reach = within + self._least
        candidates = np.flatnonzero(np.einsum("ki,ki->k", between, between) < reach**2)
        if not len(candidates):
            return []
        pin.updateGeometryPlacements(self._model, data, self._geometry, self._placed)
        known: dict[tuple[int, int], Near] = {}
        for k in candidates.tolist():
            found = pin.computeDistance(self._geometry, self._placed, k)
            if found.min_distance < within:
                near, limbs = self._near(data, k, found), self._limbs[k]
                if not near.slope.any():
                    continue
                if limbs not in known or near.turn < known[limbs].turn:
                    known[limbs] = near
        return sorted(known.values(), key=lambda near: near.turn)

    def soonest(self, postures: Array, count: int, within: float) -> tuple[Array, Array]:
        """The first `count` of those `within` (m) of each other in postures q (T, nq).

        Returns:
            (T, count) m, infinite where no more are near; (T, count, J) m per rad or m: derivatives
            of these by the joints.
        """
        data = self._model.createData()
        least = np.full((len(postures), count), np.inf)
        slopes = np.zeros((*least.shape, self._model.nv - 6))
        for t, q in enumerate(postures):
            pin.computeJointJacobians(self._model, data, q)
            for i, near in enumerate(self.at(data, within)[:count]):
                least[t, i], slopes[t, i] = near.distance, near.slope
        return least, slopes

    def _near(self, data: pin.Data, pair: int, found: coal.DistanceResult) -> Near:
        shapes = self._shapes.shapes
        joints = shapes[self._one[pair]].joint, shapes[self._other[pair]].joint
        points = np.array([found.getNearestPoint1(), found.getNearestPoint2()])
        normal = np.array(found.normal)
        # How fast a point of a body moves along the normal is the power of a unit force there.
        along = [
            np.concatenate([normal, pin.skew(point).dot(normal)]).dot(
                pin.getJointJacobian(self._model, data, joint, pin.ReferenceFrame.WORLD)
            )
            for joint, point in zip(joints, points, strict=True)
        ]
        return Near(found.min_distance, (along[1] - along[0])[6:], joints, points, normal)


def _acceleration(data: pin.Data, joint: int, point: Array) -> Array:
    """(3,) m/s2 of a point (3,) m of a body, world frame."""
    placement, velocity, acceleration = data.oMi[joint], data.v[joint], data.a[joint]
    arm, turn = placement.actInv(point), pin.skew(velocity.angular)
    moves = velocity.linear + turn.dot(arm)
    turns = pin.skew(acceleration.angular).dot(arm) + turn.dot(moves)
    found: Array = placement.rotation.dot(acceleration.linear + turns)
    return found
