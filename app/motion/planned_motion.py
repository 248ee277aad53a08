"""A plan turned into frames: everything the scene draws of it, computed once for all instants."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from app.motion.frames import FRAME_RATE, Frames, make_frames
from llsrbm.analysis.inertia_ellipsoid import ellipsoid
from llsrbm.motion.plan import Plan
from llsrbm.motion.whole_body import WholeBodyMotion, whole_body_motion
from llsrbm.robots import Robot

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PlannedMotion:
    """A plan, ready to be drawn.

    Attributes:
        plan: where it comes from.
        motion: the plan at the frames' instants.
        frames: of the planned robot, with the model's inertia.
        rigid_axes: (3,) m and rigid_wxyz: (F, 4): ellipsoid of the constant inertia that SRBM has.
    """

    plan: Plan
    motion: WholeBodyMotion
    frames: Frames
    rigid_axes: Array
    rigid_wxyz: Array


def presentable(plan: Plan) -> bool:
    """Whether a plan can be drawn at all; a solver that diverged may leave anything."""
    arrays = (plan.time, plan.com, plan.base_quat, plan.joint_position, plan.inertia)
    return all(np.isfinite(a).all() for a in arrays) and bool((np.diff(plan.time) > 0).all())


def bake_plan(plan: Plan, robot: Robot) -> PlannedMotion:
    """All frames of a plan; takes some milliseconds."""
    motion = whole_body_motion(plan, FRAME_RATE, events=True)
    base = Rotation.from_quat(motion.base_quat, scalar_first=True)
    rigid_axes, rigid_turn = ellipsoid(robot.inertia[None], robot.mass, np.eye(3)[None])
    rigid = base * Rotation.from_quat(rigid_turn[0], scalar_first=True)
    frames = make_frames(motion, plan.schedule)
    return PlannedMotion(plan, motion, frames, rigid_axes[0], rigid.as_quat(scalar_first=True))
