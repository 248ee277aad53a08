"""Plans, rollouts and other motions turned into frames: computed once for all instants."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from llsrbm.analysis.figures import DesignFigures, figures_of_motion, figures_of_rollout
from llsrbm.analysis.inertia_ellipsoid import ellipsoid
from llsrbm.arrays import Array
from llsrbm.look.shown_motion import ShownMotion, shown_motion, shown_ticks
from llsrbm.mechanics import rotation_matrices
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.surroundings import ground_under
from llsrbm.motion.whole_body import (
    WholeBodyMotion,
    motion_at_ticks,
    motion_of_states,
    velocities,
    whole_body_motion,
)
from llsrbm.robots import Robot

FRAME_RATE = 60.0
"""Frames/s of motion; browsers mix neighbouring ones at lower speeds."""

ARROW_PER_SPEED = 2.0
"""Length of the arrow of a push that gives the robot 1 m/s, m: such as matter reach out of it."""


@dataclass(frozen=True, eq=False)
class PlannedMotion:
    """A plan, ready to be drawn."""

    plan: Plan  # where it comes from
    motion: WholeBodyMotion  # the plan at the frames' instants
    frames: ShownMotion  # of the planned robot, with the model's inertia
    # (3,) m and rigid_wxyz: (F, 4): ellipsoid of the constant inertia that SRBM has
    rigid_axes: Array
    rigid_wxyz: Array
    ground: float  # m: its height under everything that the robot stands on


def presentable(plan: Plan) -> bool:
    """Whether a plan can be drawn at all; a solver that diverged may leave anything."""
    arrays = (plan.time, plan.com, plan.base_quat, plan.joint_position, plan.inertia)
    return all(np.isfinite(a).all() for a in arrays) and bool((np.diff(plan.time) > 0).all())


def bake_plan(plan: Plan, robot: Robot, rate: float = FRAME_RATE) -> PlannedMotion:
    """All frames of a plan, `rate` a second; takes some milliseconds."""
    motion = whole_body_motion(plan, rate, events=True)
    base = Rotation.from_quat(motion.base_quat, scalar_first=True)
    rigid_axes, rigid_turn = ellipsoid(robot.inertia[None], robot.mass, np.eye(3)[None])
    rigid = base * Rotation.from_quat(rigid_turn[0], scalar_first=True)
    frames = shown_motion(motion, plan.schedule)
    return PlannedMotion(
        plan,
        motion,
        frames,
        rigid_axes[0],
        rigid.as_quat(scalar_first=True),
        ground_under(plan),
    )


@dataclass(frozen=True, eq=False)
class SimulatedMotion:
    """A rollout, ready to be drawn."""

    rollout: Rollout  # where it comes from
    # of the simulated robot, with the whole body's inertia; contact forces are means over a frame
    frames: ShownMotion


def bake_rollout(rollout: Rollout, rate: float = FRAME_RATE) -> SimulatedMotion:
    """All frames of a rollout, about `rate` a second; every frame is one of its ticks."""
    tick = float(np.diff(rollout.time[:2])[0]) if len(rollout.time) > 1 else 1 / rate
    stride = max(1, round(1 / (tick * rate)))
    # The last tick is drawn, whatever the stride: it is where the robot stands, or lies.
    kept = np.arange((len(rollout.time) - 1) % stride, len(rollout.time), stride)
    return SimulatedMotion(rollout, shown_ticks(rollout, np.union1d(kept, 0)))


def frames_so_far(robot: Robot, time: Array, qpos: Array) -> ShownMotion:
    """Frames of a simulation that still runs, at `time` (K,) s, K > 0: five a second are cheap.

    Its contact forces are not known yet, and which feet stand follows from how they move. `qpos`
    (K, 7 + J) is in MuJoCo's convention, joints in `Robot.joint_names`' order.
    """
    still = np.zeros((1, qpos.shape[1] - 1))
    qvel = velocities(time, qpos) if len(time) > 1 else still
    return shown_motion(motion_of_states(robot, "simulation", time, qpos, qvel))


@dataclass(frozen=True, eq=False)
class ForeignMotion:
    """A motion, ready to be drawn."""

    name: str  # of its file
    motion: WholeBodyMotion  # at the file's own instants
    frames: ShownMotion  # of the robot
    figures: DesignFigures  # its row in the comparison


def bake_foreign(name: str, motion: WholeBodyMotion | Rollout) -> ForeignMotion:
    """All frames of another tool's motion, or of a rollout whose plan is not known."""
    if isinstance(motion, Rollout):
        return ForeignMotion(
            name,
            motion_at_ticks(motion, np.arange(len(motion.time))),
            bake_rollout(motion).frames,
            figures_of_rollout(motion),
        )
    return ForeignMotion(name, motion, shown_motion(motion), figures_of_motion(motion))


def trunk_com(robot: Robot, frames: ShownMotion) -> Array:
    """The trunk's own CoM (F, 3) m, on which pushes act."""
    turn = rotation_matrices(frames.body_wxyz[:, 0])
    arm = robot.model.inertias[1].lever
    return np.asarray(frames.body_position[:, 0] + turn @ arm)


def metres_per_newton_second(robot: Robot) -> float:
    """Length of a push's arrow over its impulse."""
    return ARROW_PER_SPEED / float(robot.mass)
