"""Checks of distances: between links of the robot, and from them to the ground and what is on it.

Shapes are those of the URDF's collision geometry, distances coal's.
"""

from collections.abc import Sequence

import coal
import numpy as np

from llsrbm.arrays import Array
from llsrbm.certificate.finding import Check
from llsrbm.certificate.sampled_motion import SampledMotion
from llsrbm.motion.block import Block
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.surroundings import Surroundings, surroundings
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.request.scenario import Scenario
from llsrbm.robots.least_distance import least_distance, way_of
from llsrbm.robots.link_shapes import LinkShapes
from llsrbm.robots.robot import Robot
from llsrbm.robots.shapes import Shape, link_shapes

TOUCHING = -0.005  # m: feet and legs are as far off between a plan's knots
# Of another tool's motion: m within which feet stand on the same level, and the share of their
# instants that may be lower than all others.
LEVEL, RARE = 0.015, 0.02


class SelfDistance(Check):
    """Links that can meet keep apart: worst is their least distance in m, negative inside each
    other; at least 5 mm, or half of what they are apart as the robot stands if that is less.
    """

    name, unit = "self_distance", "m"

    def take(self, motion: SampledMotion) -> None:
        """The nearest pair of links."""
        shapes = LinkShapes.of(motion.robot)
        if not shapes.pairs:
            self.nothing("no links can meet")
            return
        if (lost := motion.lost) is not None:
            self.least(motion, -np.inf, lost, float(shapes.apart.max()), "")
            return
        distance, instant, pair = shapes.least(motion.q, shapes.apart)
        apart = float(shapes.apart[shapes.pairs.index(pair)])
        self.least(motion, distance, instant, apart, " - ".join(pair))


class Clearance(Check):
    """Nothing but standing feet is in the ground, a box, a board or a hurdle.

    worst: least distance in m from a link to any of them, the links of standing feet left out;
    negative inside. 5 mm of touching are allowed: as much do feet wander between a plan's knots.
    In another tool's motion the ground alone is known: it is the lowest level on which feet stand.
    """

    name, unit = "clearance", "m"

    def __init__(self) -> None:
        super().__init__()
        self._around: Surroundings | None = None
        self._geometries: list[coal.ShapeBase] = []  # of the links' shapes

    def take(self, motion: SampledMotion) -> None:
        """The link that is nearest to its surroundings, or deepest in them."""
        if self._around is None:
            self._around = _around(motion)
        if self._around is None:
            self.unknown("no foot stands, so the height of the ground is not known")
            return
        if (lost := motion.lost) is not None:
            self.least(motion, -np.inf, lost, TOUCHING, "")
            return
        if not self._geometries:
            self._geometries = [shape.geometry() for shape in link_shapes(motion.robot)]
        distance, instant, name = _nearest(motion, self._around, self._geometries)
        self.least(motion, distance, instant, TOUCHING, name)


def _around(motion: SampledMotion) -> Surroundings | None:
    source = motion.source
    if isinstance(source, Rollout):
        return surroundings(motion.robot, source.plan, source.scenario)
    if not isinstance(source, WholeBodyMotion):
        return surroundings(motion.robot, source, Scenario())
    heights = source.foot_position[..., 2][source.contact]
    if not len(heights):
        return None
    lowest = heights < np.quantile(heights, RARE) + LEVEL
    return Surroundings(float(np.median(heights[lowest])), ())


def _nearest(
    motion: SampledMotion, around: Surroundings, geometries: Sequence[coal.ShapeBase]
) -> tuple[float, int, str]:
    """The least distance, m, its instant's number, and what is that near to what.

    `geometries`: of the links' shapes.
    """
    shapes, bodies = link_shapes(motion.robot), around.solids
    boxes = [coal.Box(*block.size) for block in bodies]
    places = [coal.Transform3s(block.rotation, block.centre) for block in bodies]
    rotation, centre = _placed(motion, shapes)
    middles, radii = (np.array(each) for each in zip(*map(_sphere, geometries), strict=True))
    middle = centre + np.einsum("ksij,sj->ksi", rotation, middles)
    bound = _at_least(motion, around, shapes, middle, radii)
    request, result = coal.DistanceRequest(), coal.DistanceResult()

    def measure(instant: int, pair: int) -> float:
        s, b = divmod(pair, len(boxes))
        result.clear()
        here = coal.Transform3s(rotation[instant, s], centre[instant, s])
        return float(coal.distance(geometries[s], here, boxes[b], places[b], request, result))

    def way(pair: int) -> Array:
        s = pair // len(boxes)
        return way_of(rotation[:, s], middle[:, s], radii[s])

    least, instant, pair = least_distance(bound.reshape(len(bound), -1), measure, way)
    s, b = divmod(pair, len(boxes))
    return least, instant, f"{shapes[s].link} - {bodies[b].name}"


def _placed(motion: SampledMotion, shapes: Sequence[Shape]) -> tuple[Array, Array]:
    """(K, S, 3, 3), (K, S, 3) m: turn and centre of each shape at each instant."""
    of = [shape.joint for shape in shapes]
    turn, at = (each[:, of] for each in motion.placed)
    centres = np.array([shape.centre for shape in shapes])
    rotation = turn @ np.array([shape.rotation for shape in shapes])
    return rotation, at + np.einsum("ksij,sj->ksi", turn, centres)


def _at_least(
    motion: SampledMotion,
    around: Surroundings,
    shapes: Sequence[Shape],
    middle: Array,
    radii: Array,
) -> Array:
    """(K, S, B) m, no more than a shape's distance from a body; inf where it does not count.

    `middle`: (K, S, 3) m of spheres around the shapes, of `radii` (S,) m.
    """
    bound = np.stack([_from_box(block, middle) for block in around.solids], axis=-1)
    bound -= radii[:, None]
    for b, block in enumerate(around.solids):
        there = (block.from_s <= motion.time) & (motion.time < block.until_s)
        bound[~there, :, b] = np.inf
    for s, shape in enumerate(shapes):
        leg = _leg_of(motion.robot, shape)
        if leg is not None:
            bound[motion.contact[:, leg], s] = np.inf
    return bound


def _leg_of(robot: Robot, shape: Shape) -> int | None:
    """The leg on whose foot a shape is; None: it is on no foot."""
    joints = [robot.model.frames[leg.foot_frame_id].parentJoint for leg in robot.legs]
    return joints.index(shape.joint) if shape.foot else None


def _sphere(geometry: coal.ShapeBase) -> tuple[Array, float]:
    """Around a shape: (3,) m in its frame, and radius, m."""
    geometry.computeLocalAABB()
    return np.array(geometry.aabb_center), float(geometry.aabb_radius)


def _from_box(block: Block, points: Array) -> Array:
    """(...) distance of points (..., 3) from a box, m; negative inside, by the nearest face."""
    beyond = np.abs((points - block.centre) @ block.rotation) - np.asarray(block.size) / 2
    outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=-1)
    return np.asarray(outside + np.minimum(beyond.max(axis=-1), 0.0))
