"""Checks of distances: between links of the robot, and from them to the ground and what is on it.

Shapes are those of the URDF's collision geometry, distances coal's.
"""

from __future__ import annotations

import math
from typing import ClassVar

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.certificate.finding import Check, Finding
from llsrbm.certificate.sampled_motion import SampledMotion
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.surroundings import Block, Surroundings, surroundings
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.request.scenario import Scenario
from llsrbm.robots.link_shapes import LinkShapes
from llsrbm.robots.robot import Robot
from llsrbm.robots.shapes import Shape, link_shapes

Array = NDArray[np.float64]

APART = 0.005  # m between links
TOUCHING = -0.005  # m: feet and legs are as far off between a plan's knots


class SelfDistance(Check):
    """Links that can meet keep apart: worst is their least distance in m, negative inside each
    other; at least 5 mm.
    """

    name: ClassVar[str] = "self_distance"
    unit: ClassVar[str] = "m"

    def find(self, motion: SampledMotion) -> Finding:
        """The nearest pair of links."""
        shapes = LinkShapes.of(motion.robot)
        if not shapes.pairs:
            return self.nothing("no links can meet")
        distance, pair = shapes.nearest(motion.q)
        names = [" - ".join(shapes.pairs[k]) for k in pair]
        return self.least(motion, distance, APART, names)


class Clearance(Check):
    """Nothing but standing feet is in the ground, a box, a board or a hurdle.

    worst: least distance in m from a link to any of them, the links of standing feet left out;
    negative inside. 5 mm of touching are allowed: as much do feet wander between a plan's knots.
    In another tool's motion the ground alone is known: it is where feet stand.
    """

    name: ClassVar[str] = "clearance"
    unit: ClassVar[str] = "m"

    def find(self, motion: SampledMotion) -> Finding:
        """The link that is nearest to its surroundings, or deepest in them."""
        around = _around(motion)
        if around is None:
            return self.unknown("no foot stands, so the height of the ground is not known")
        distance, names = _nearest(motion, around)
        return self.least(motion, distance, TOUCHING, names)


def _around(motion: SampledMotion) -> Surroundings | None:
    source = motion.source
    if isinstance(source, Rollout):
        return surroundings(motion.robot, source.plan, source.scenario)
    if not isinstance(source, WholeBodyMotion):
        return surroundings(motion.robot, source, Scenario())
    heights = source.foot_position[..., 2][source.contact]
    return Surroundings(float(np.median(heights)), ()) if len(heights) else None


def _nearest(motion: SampledMotion, around: Surroundings) -> tuple[Array, list[str]]:
    """(K,) m, the least distance at each instant, and what is that near to what."""
    shapes = link_shapes(motion.robot)
    legs = [_leg_of(motion.robot, shape) for shape in shapes]
    bodies = around.solids
    geometries = [shape.geometry() for shape in shapes]
    boxes = [coal.Box(*block.size) for block in bodies]
    places = [coal.Transform3s(_turn(block.yaw), block.centre) for block in bodies]
    spheres = [_sphere(geometry) for geometry in geometries]
    model, data = motion.model, motion.model.createData()
    least, names = np.full(len(motion.time), np.inf), [""] * len(motion.time)
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    for k, (time, q) in enumerate(zip(motion.time, motion.q, strict=True)):
        pin.forwardKinematics(model, data, q)
        for shape, leg, geometry, (middle, radius) in zip(
            shapes, legs, geometries, spheres, strict=True
        ):
            if leg is not None and motion.contact[k, leg]:
                continue
            joint = data.oMi[shape.joint]
            rotation = joint.rotation @ shape.rotation
            centre = joint.act(shape.centre)
            at = rotation @ middle + centre
            for block, box, place in zip(bodies, boxes, places, strict=True):
                if not block.from_s <= time < block.until_s:
                    continue
                if _from_box(block, place, at) - radius >= least[k]:
                    continue
                result.clear()
                here = coal.Transform3s(rotation, centre)
                distance = float(coal.distance(geometry, here, box, place, request, result))
                if distance < least[k]:
                    least[k], names[k] = distance, f"{shape.link} - {block.name}"
    return least, names


def _leg_of(robot: Robot, shape: Shape) -> int | None:
    """The leg on whose foot a shape is; None: it is on no foot."""
    joints = [robot.model.frames[leg.foot_frame_id].parentJoint for leg in robot.legs]
    return joints.index(shape.joint) if shape.foot else None


def _turn(yaw: float) -> Array:
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _sphere(geometry: coal.ShapeBase) -> tuple[Array, float]:
    """Around a shape: (3,) m in its frame, and radius, m."""
    geometry.computeLocalAABB()
    return np.array(geometry.aabb_center), float(geometry.aabb_radius)


def _from_box(block: Block, place: coal.Transform3s, point: Array) -> float:
    """Distance of a point from a box, m; negative inside, by the nearest face."""
    beyond = np.abs(place.getRotation().T @ (point - block.centre)) - block.size / 2
    outside = float(np.linalg.norm(np.maximum(beyond, 0.0)))
    return outside + min(float(beyond.max()), 0.0)
