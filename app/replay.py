"""A plan turned into frames: everything the scene draws of it, computed once for all instants."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from app.frames import FRAME_RATE, Frames, make_frames
from llsrbm.motion.inertia_ellipsoid import ellipsoid
from llsrbm.motion.instants import with_events
from llsrbm.motion.plan import Phase, Plan
from llsrbm.motion.resample import resample
from llsrbm.robots import Robot

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Replay:
    """A plan, ready to be drawn.

    Attributes:
        plan: where it comes from.
        motion: the plan at the frames' instants.
        frames: of the planned robot, with the model's inertia.
        rigid_axes: (3,) m and rigid_wxyz: (F, 4): ellipsoid of the constant inertia that SRBM has.
    """

    plan: Plan
    motion: Plan
    frames: Frames
    rigid_axes: Array
    rigid_wxyz: Array


def presentable(plan: Plan) -> bool:
    """Whether a plan can be drawn at all; a solver that diverged may leave anything."""
    arrays = (plan.time, plan.com, plan.base_quat, plan.joint_position, plan.inertia)
    return all(np.isfinite(a).all() for a in arrays) and bool((np.diff(plan.time) > 0).all())


def bake(plan: Plan, robot: Robot) -> Replay:
    """All frames of a plan; takes some milliseconds."""
    motion = resample(plan, with_events(plan, FRAME_RATE))
    foot_force, pressed_at = resultants(motion.contact_point, motion.contact_force, len(robot.legs))
    frames = make_frames(
        robot,
        time=motion.time,
        com=motion.com,
        base_position=motion.base_position,
        base_quat=motion.base_quat,
        joint_position=motion.joint_position,
        inertia=motion.inertia,
        foot_position=motion.foot_position,
        flight=motion.phase == Phase.FLIGHT,
        foot_force=foot_force,
        pressed_at=pressed_at,
    )
    base = Rotation.from_quat(motion.base_quat, scalar_first=True)
    rigid_axes, rigid_turn = ellipsoid(robot.inertia[None], robot.mass, np.eye(3)[None])
    rigid = base * Rotation.from_quat(rigid_turn[0], scalar_first=True)
    return Replay(plan, motion, frames, rigid_axes[0], rigid.as_quat(scalar_first=True))


def resultants(points: Array, forces: Array, feet: int) -> tuple[Array, Array]:
    """Forces on feet, (F, L, 3) N, and where they act, (F, L, 3) m: the centres of pressure.

    Args:
        points: (F, C, 3) m, feet x contacts of a foot.
        forces: (F, C, 3) N, at the points.
        feet: L.
    """
    points, forces = (values.reshape(len(values), feet, -1, 3) for values in (points, forces))
    total = forces.sum(axis=2)
    vertical = forces[..., 2:]
    pushed = total[..., 2:] > 0
    weighted = (vertical * points).sum(axis=2) / np.where(pushed, total[..., 2:], 1.0)
    return total, np.where(pushed, weighted, points.mean(axis=2))
