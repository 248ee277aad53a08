"""`ShownMotion`: a motion ready to be drawn, on the page, in pictures, videos and logs."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from llsrbm.analysis.inertia_ellipsoid import ellipsoid
from llsrbm.arrays import Array, BoolArray, IntArray
from llsrbm.body.momentum import momentum_and_inertia
from llsrbm.errors import InputError
from llsrbm.look.visuals import LinkVisual, forward_kinematics
from llsrbm.mechanics import GRAVITY, interpolated, rotation_matrices, sign_continuous
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.surroundings import Surroundings, surroundings
from llsrbm.motion.trajectory import Trajectory
from llsrbm.motion.whole_body import WholeBodyMotion, motion_at, motion_at_ticks
from llsrbm.request.scenario import Scenario
from llsrbm.request.schedule import Schedule
from llsrbm.robots import Robot

ARROW_PER_WEIGHT = 0.8  # m, length of the arrow of a force as large as the robot's weight
_PUSHING = 1.0  # N; smaller forces have no arrow


@dataclass(frozen=True, eq=False)
class ShownMotion:
    """F instants of a robot in motion, world frame: B bodies, L feet with c contact points each."""

    motion: WholeBodyMotion  # at these instants
    time: Array  # (F,) s of the motion's own time
    mass: float  # kg of what moves: that of the simulated trunk may be off
    body_position: Array  # (F, B, 3) m and body_wxyz: (F, B, 4): pose of every moving body
    body_wxyz: Array
    inertia_axes: Array  # (F, 3) m and inertia_wxyz: (F, 4): ellipsoid of the inertia about the CoM
    inertia_wxyz: Array
    # (F, L) whether a foot is to stand: by the phase of the plan or of the controller
    stands: BoolArray
    foot_force: Array  # (F, L, 3) N: the sum over a foot's contacts
    pressed_at: Array  # (F, L, 3) m: where it acts, a sole's centre of pressure

    @property
    def robot(self) -> Robot:
        """That moves."""
        return self.motion.robot

    @property
    def com(self) -> Array:
        """(F, 3) m."""
        return self.motion.com

    @property
    def foot_position(self) -> Array:
        """(F, L, 3) m."""
        return self.motion.foot_position

    @property
    def contact(self) -> BoolArray:
        """(F, L) whether a foot does stand."""
        return self.motion.contact

    @property
    def angular_momentum(self) -> Array:
        """(F, 3) kg m2/s about the CoM."""
        return self.motion.angular_momentum

    @property
    def weight(self) -> float:
        """Weight of the moving robot, N."""
        return self.mass * GRAVITY

    @property
    def end(self) -> float:
        """Time of the last instant, s."""
        return float(self.time[-1])

    @property
    def arrows(self) -> Array:
        """(F, L, 3) m: contact forces as arrows, without a length where a foot hardly pushes."""
        pushing = np.linalg.norm(self.foot_force, axis=2, keepdims=True) > _PUSHING
        return np.where(pushing, self.foot_force * (ARROW_PER_WEIGHT / self.weight), 0.0)

    @cached_property
    def yaw_wxyz(self) -> Array:
        """(F, 4): turns about the vertical that take x where the base takes it, seen from above."""
        x = rotation_matrices(self.motion.base_quat)[:, :2, 0]
        yaw = np.arctan2(x[:, 1], x[:, 0])[:, None]
        return Rotation.from_euler("z", yaw).as_quat(scalar_first=True)

    @cached_property
    def contact_point(self) -> Array:
        """(F, L, c, 3) m: corners of the soles, however they are tilted; a point foot itself."""
        robot = self.robot
        if robot.file.foot.is_point:
            return self.foot_position[:, :, None]
        points = []
        for leg in robot.legs:
            placement = robot.model.frames[leg.foot_frame_id].placement
            corners = robot.corners @ placement.rotation.T + placement.translation
            body = leg.joint_ids[-1] - 1
            turn = rotation_matrices(self.body_wxyz[:, body])
            points.append(self.body_position[:, body, None] + corners @ turn.transpose(0, 2, 1))
        return np.stack(points, axis=1)

    @cached_property
    def held_arms(self) -> tuple[Array, Array] | None:
        """(F, 3) m, (F, 4): ellipsoid were the arms held; None: the robot has none."""
        robot, joints = self.robot, self.motion.joint_position.copy()
        if not robot.arms:
            return None
        joints[:, robot.arm_joint_index] = robot.arm_angles
        base = rotation_matrices(self.motion.base_quat)
        still = np.zeros((len(base), 3))
        _, inertia = momentum_and_inertia(robot, joints, np.zeros_like(joints), still)
        return ellipsoid(base @ inertia @ base.transpose(0, 2, 1), self.mass, base)

    def poses(self, visuals: Sequence[LinkVisual]) -> Array:
        """(F, n, 7) of n meshes: position, quaternion without jumps of sign."""
        index = [visual.joint_id - 1 for visual in visuals]
        wxyz = np.stack([sign_continuous(self.body_wxyz[:, body]) for body in index], axis=1)
        return np.concatenate([self.body_position[:, index], wxyz], axis=2)


def shown_motion(
    motion: WholeBodyMotion,
    schedule: Schedule | None = None,  # without it feet are to stand where they do
    *,
    mass: float | None = None,  # kg; None: the robot's
    time: Array | None = None,  # (F,) s; None: from 0 on
) -> ShownMotion:
    """At a motion's instants."""
    robot = motion.robot
    mass = float(robot.mass) if mass is None else mass
    stands = motion.contact
    if schedule is not None and motion.phase is not None:
        stands = schedule.stands[motion.phase]
    force, pressed_at = motion.foot_force, motion.pressed_at
    return ShownMotion(
        motion,
        motion.time if time is None else time,
        mass,
        *forward_kinematics(robot, motion.base_position, motion.base_quat, motion.joint_position),
        *ellipsoid(motion.inertia, mass, rotation_matrices(motion.base_quat)),
        stands=np.asarray(stands, dtype=np.bool_),
        # Arrows of no length where no file says how the feet push.
        foot_force=np.zeros_like(motion.foot_position) if force is None else force,
        pressed_at=motion.foot_position if pressed_at is None else pressed_at,
    )


def shown_trajectory(trajectory: Trajectory, time: Array) -> ShownMotion:
    """A plan or a rollout at instants (F,) s, increasing; forces of a rollout are means.

    Raises:
        InputError: the robot has other joints by now, or the motion has numbers that are none.
        RobotFileError: the robot is not there.
    """
    check_finite(trajectory)
    motion = motion_at(trajectory, time)
    if isinstance(trajectory, Rollout):
        motion = _with_mean_forces(motion, trajectory, time)
    mass = mass_of(trajectory, motion.robot)
    return shown_motion(motion, trajectory.schedule, mass=mass, time=time)


def shown_ticks(rollout: Rollout, ticks: IntArray) -> ShownMotion:
    """A rollout at some of its own ticks (F,), increasing; errors as of `shown_trajectory`."""
    motion = _with_mean_forces(motion_at_ticks(rollout, ticks), rollout, rollout.time[ticks])
    return shown_motion(motion, rollout.schedule, mass=mass_of(rollout, motion.robot))


def check_finite(trajectory: Trajectory) -> None:
    """Raise `InputError` unless a motion can be drawn: a solver that diverged leaves anything."""
    for name in ("time", "com", "base_position", "base_quat", "joint_position", "inertia"):
        if not np.isfinite(getattr(trajectory, name)).all():
            raise InputError(f"{name} is not finite everywhere; expected a motion to be drawn")


def mass_of(trajectory: Trajectory, robot: Robot) -> float:
    """Mass (kg) of what moved."""
    return float(robot.mass if isinstance(trajectory, Plan) else trajectory.disturbance.mass(robot))


def surroundings_of(trajectory: Trajectory, robot: Robot) -> Surroundings:
    """Ground and blocks, as far as they are known."""
    if isinstance(trajectory, Plan):
        return surroundings(robot, trajectory, Scenario())
    return surroundings(robot, trajectory.plan, trajectory.scenario)


def _with_mean_forces(motion: WholeBodyMotion, rollout: Rollout, time: Array) -> WholeBodyMotion:
    """Forces that are means from each of `time` (F,) s to the next; as sampled where there is none.

    The rollout holds them from tick to tick.
    """
    ticks, values = rollout.time, rollout.contact_force
    assert motion.foot_force is not None  # rollouts have them
    pushed = np.cumsum(np.diff(ticks)[:, None, None] * values[:-1], axis=0)
    total = np.concatenate([np.zeros((1, *values.shape[1:])), pushed])
    means = np.diff(interpolated(time, ticks, total), axis=0) / np.diff(time)[:, None, None]
    within = (time[:-1] >= ticks[0] - 1e-9) & (time[1:] <= ticks[-1] + 1e-9)
    force = motion.foot_force.copy()
    force[:-1][within] = means[within]
    return replace(motion, foot_force=force)
