"""Plans, rollouts and other motions turned into frames: computed once for all instants."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from app.motion.frames import FRAME_RATE, Frames, make_frames
from llsrbm.analysis.figures import DesignFigures, figures_of_motion, figures_of_rollout
from llsrbm.analysis.inertia_ellipsoid import ellipsoid
from llsrbm.mechanics import Array, rotation_matrices, sign_continuous
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.whole_body import WholeBodyMotion, motion_at_ticks, standing, whole_body_motion
from llsrbm.robots import Robot
from llsrbm.robots.feet import foot_contacts

ARROW_PER_SPEED = 2.0
"""Length of the arrow of a push that gives the robot 1 m/s, m: such as matter reach out of it."""


@dataclass(frozen=True, eq=False)
class PlannedMotion:
    """A plan, ready to be drawn."""

    plan: Plan  # where it comes from
    motion: WholeBodyMotion  # the plan at the frames' instants
    frames: Frames  # of the planned robot, with the model's inertia
    # (3,) m and rigid_wxyz: (F, 4): ellipsoid of the constant inertia that SRBM has
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


@dataclass(frozen=True, eq=False)
class SimulatedMotion:
    """A rollout, ready to be drawn."""

    rollout: Rollout  # where it comes from
    # of the simulated robot, with the whole body's inertia; contact forces are means over a frame
    frames: Frames


def bake_rollout(rollout: Rollout) -> SimulatedMotion:
    """All frames of a rollout; every frame is one of its ticks."""
    tick = float(np.diff(rollout.time[:2])[0]) if len(rollout.time) > 1 else 1 / FRAME_RATE
    stride = max(1, round(1 / (tick * FRAME_RATE)))
    # The last tick is drawn, whatever the stride: it is where the robot stands, or lies.
    kept = np.arange((len(rollout.time) - 1) % stride, len(rollout.time), stride)
    kept = np.union1d(kept, 0)
    motion = motion_at_ticks(rollout, kept)
    motion = replace(motion, foot_force=means_from(rollout.contact_force, kept))
    return SimulatedMotion(rollout, make_frames(motion, rollout.schedule))


def means_from(values: Array, first: NDArray[np.int64]) -> Array:
    """Means of `values` (T, ...) over the stretches that begin at `first` (F,), increasing."""
    counts = np.diff(np.append(first, len(values)))
    sums = np.add.reduceat(values, first, axis=0)
    means: Array = sums / counts.reshape(-1, *([1] * (values.ndim - 1)))
    return means


def frames_so_far(robot: Robot, time: Array, qpos: Array) -> Frames:
    """Frames of a simulation that still runs, at `time` (K,) s, K > 0: five a second are cheap.

    Its contact forces are not known yet, and which feet stand follows from how they move. `qpos`
    (K, 7 + J) is in MuJoCo's convention, joints in `Robot.joint_names`' order.
    """
    com, inertia, feet = _from_states(robot, qpos)
    rates = np.zeros((len(time), qpos.shape[1] - 7))
    speed = np.zeros(feet.shape[:2])
    if len(time) > 1:
        speed = np.linalg.norm(np.gradient(feet, time, axis=0), axis=-1)
    zeros = np.zeros((len(time), 3))
    return make_frames(
        WholeBodyMotion(
            robot=robot,
            origin="simulation",
            time=time,
            fps=None,
            base_position=qpos[:, :3],
            base_quat=sign_continuous(qpos[:, 3:7]),
            # Frames have no velocities.
            base_velocity=zeros,
            angular_velocity=zeros,
            joint_position=qpos[:, 7:],
            joint_velocity=rates,
            com=com,
            linear_momentum=zeros,
            angular_momentum=zeros,
            inertia=inertia,
            foot_position=feet,
            contact=standing(time, speed, feet[..., 2]),
        )
    )


def _from_states(robot: Robot, qpos: Array) -> tuple[Array, Array, Array]:
    """CoM (K, 3), inertia about it (K, 3, 3) and feet (K, L, 3) of the whole body."""
    model, data, contacts = robot.model, robot.model.createData(), foot_contacts(robot)
    q = np.concatenate([qpos[:, :3], qpos[:, 4:7], qpos[:, 3:4], qpos[:, 7:]], axis=1)
    v = np.zeros(model.nv)
    com, inertia = np.empty((len(q), 3)), np.empty((len(q), 3, 3))
    feet = np.empty((len(q), len(contacts), 3))
    middles = [contact.centres.mean(axis=0) for contact in contacts]
    for k in range(len(q)):
        pin.ccrba(model, data, q[k], v)
        com[k], inertia[k] = data.com[0], data.Ig.inertia
        for i, leg in enumerate(robot.legs):
            frame = pin.updateFramePlacement(model, data, leg.foot_frame_id)
            feet[k, i] = frame.act(middles[i])
    feet[..., 2] -= np.array([contact.radius for contact in contacts])
    return com, inertia, feet


@dataclass(frozen=True, eq=False)
class ForeignMotion:
    """A motion, ready to be drawn."""

    name: str  # of its file
    motion: WholeBodyMotion  # at the file's own instants
    frames: Frames  # of the robot
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
    return ForeignMotion(name, motion, make_frames(motion), figures_of_motion(motion))


def trunk_com(robot: Robot, frames: Frames) -> Array:
    """The trunk's own CoM (F, 3) m, on which pushes act."""
    turn = rotation_matrices(frames.body_wxyz[:, 0])
    arm = robot.model.inertias[1].lever
    return np.asarray(frames.body_position[:, 0] + turn @ arm)


def metres_per_newton_second(robot: Robot) -> float:
    """Length of a push's arrow over its impulse."""
    return ARROW_PER_SPEED / float(robot.mass)
