"""Whether a planned robot reaches into a block: its trunk, its links, its feet."""

import coal
import numpy as np
import pinocchio as pin

from llsrbm.arrays import BoolArray
from llsrbm.body.trunk_and_knees import trunk_box
from llsrbm.mechanics import rotation_matrices
from llsrbm.motion.block import Block
from llsrbm.motion.plan import Plan
from llsrbm.robots.link_shapes import LinkShapes
from llsrbm.robots.robot import Robot

TRUNK_POINTS = 9  # a side, of the trunk's box that are looked at


def trunk_inside(robot: Robot, plan: Plan, block: Block) -> bool:
    """Whether the planned trunk reaches into a block at any knot."""
    low, high = trunk_box(robot)
    grid = np.meshgrid(*np.linspace(low, high, TRUNK_POINTS).T)
    own = np.stack(grid, axis=-1).reshape(-1, 3)
    world = plan.base_position[:, None] + own @ np.swapaxes(rotation_matrices(plan.base_quat), 1, 2)
    seen = np.abs((world - block.centre) @ block.rotation)
    return bool((seen < block.size / 2).all(axis=-1).any())


def links_inside(robot: Robot, plan: Plan, block: Block, knots: BoolArray) -> bool:
    """Whether planned links but the feet reach into a block at some of the knots."""
    if not knots.any():
        return False
    joints = plan.joint_position[:, [plan.joint_names.index(name) for name in robot.joint_names]]
    postures = np.hstack([plan.base_position, np.roll(plan.base_quat, -1, axis=1), joints])[knots]
    placement = pin.SE3(block.rotation, block.centre)
    least = LinkShapes.of(robot).clearance(postures, coal.Box(*block.size), placement)
    return bool((least < 0).any())


def feet_inside(plan: Plan, block: Block, knots: BoolArray, radius: float) -> bool:
    """Whether planned feet with balls of a radius, m, reach into a block at some of the knots."""
    centres = plan.contact_point[knots].reshape(-1, 3) + np.array([0.0, 0.0, radius])
    inside = np.abs((centres - block.centre) @ block.rotation) < block.size / 2 + radius
    return bool(inside.all(axis=-1).any())
