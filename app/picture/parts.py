"""Parts of a drawn robot that can be pointed at: its trunk, its feet, links by their joints."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from llsrbm.robots import Robot
from llsrbm.robots.urdf import BASE_JOINT

TRUNK = "trunk"

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Part:
    """Where a part is: between two points of a node; of a foot they are one."""

    name: str  # the joint's that moves it, "LF foot", or `TRUNK`
    node: str  # name of the node of the scene in whose frame the points are
    start: Point  # start, end: m
    end: Point

    @property
    def plain(self) -> dict[str, Any]:
        """For JSON."""
        return {"name": self.name, "node": self.node, "ends": [self.start, self.end]}


def foot_name(leg: str) -> str:
    """Name of a leg's foot among the parts."""
    return f"{leg} foot"


def parts_of(robot: Robot, bodies: Mapping[str, int]) -> tuple[Part, ...]:
    """Parts of a robot whose bodies, by their indices, these nodes draw; others are not seen."""
    nodes = {body + 1: node for node, body in bodies.items()}  # by Pinocchio's joint
    found = []
    if BASE_JOINT in nodes:
        # Its middle is where pushes act.
        along = np.array([np.ptp(robot.hips[:, 0]) / 2, 0.0, 0.0])
        com = robot.model.inertias[BASE_JOINT].lever
        found.append(Part(TRUNK, nodes[BASE_JOINT], _point(com - along), _point(com + along)))
    for leg in robot.legs:
        foot = robot.model.frames[leg.foot_frame_id].placement.translation
        after = [robot.model.jointPlacements[joint].translation for joint in leg.joint_ids[1:]]
        for name, joint, end in zip(leg.joints, leg.joint_ids, (*after, foot), strict=True):
            if joint in nodes:
                found.append(Part(name, nodes[joint], (0.0, 0.0, 0.0), _point(end)))
        if leg.joint_ids[-1] in nodes:
            node = nodes[leg.joint_ids[-1]]
            found.append(Part(foot_name(leg.name), node, _point(foot), _point(foot)))
    return tuple(found)


def _point(place: Any) -> Point:
    x, y, z = (round(float(value), 4) for value in place)
    return x, y, z
