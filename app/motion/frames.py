"""Instants of a motion, ready to be drawn: computed once for all of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from llsrbm.analysis.inertia_ellipsoid import ellipsoid
from llsrbm.body.momentum import momentum_and_inertia
from llsrbm.look.visuals import forward_kinematics
from llsrbm.mechanics import Array, rotation_matrices
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.request.schedule import Schedule

FRAME_RATE = 60.0  # Frames/s of motion; browsers mix neighbouring ones at lower speeds


@dataclass(frozen=True, eq=False)
class Frames:
    """F instants of a robot in motion, world frame: B bodies, L feet with c contact points each."""

    time: Array  # (F,) s
    com: Array  # (F, 3) m
    body_position: Array  # (F, B, 3) m and body_wxyz: (F, B, 4): pose of every moving body
    body_wxyz: Array
    inertia_axes: Array  # (F, 3) m and inertia_wxyz: (F, 4): ellipsoid of the inertia about the CoM
    inertia_wxyz: Array
    yaw_wxyz: Array  # (F, 4): the base's heading alone
    foot_position: Array  # (F, L, 3) m
    # (F, L) whether a foot is to stand: by the phase of the plan or of the controller
    stands: NDArray[np.bool_]
    foot_force: Array  # (F, L, 3) N: the sum over a foot's contacts
    pressed_at: Array  # (F, L, 3) m: where it acts, a sole's centre of pressure
    weight: float  # of the robot, N
    contact: NDArray[np.bool_]  # (F, L) whether a foot does stand
    contact_point: Array  # (F, L, c, 3) m: of a point foot, the foot
    angular_momentum: Array  # (F, 3) kg m2/s about the CoM
    # (F, 3) m, (F, 4): ellipsoid of the inertia were the arms held; None: the robot has none
    held_arms: tuple[Array, Array] | None = None

    @property
    def flight(self) -> NDArray[np.bool_]:
        """(F,) whether no foot is to stand."""
        return np.asarray(~self.stands.any(axis=1))

    @property
    def end(self) -> float:
        """Time of the last frame, s."""
        return float(self.time[-1])


def make_frames(motion: WholeBodyMotion, schedule: Schedule | None = None) -> Frames:
    """Frames at a motion's instants; without its `schedule` feet are to stand where they do."""
    robot = motion.robot
    body_position, body_wxyz = forward_kinematics(
        robot, motion.base_position, motion.base_quat, motion.joint_position
    )
    base = Rotation.from_quat(motion.base_quat, scalar_first=True)
    inertia_axes, inertia_wxyz = ellipsoid(motion.inertia, robot.mass, base.as_matrix())
    stands = motion.contact
    if schedule is not None and motion.phase is not None:
        stands = schedule.stands[motion.phase]
    force, pressed_at = motion.foot_force, motion.pressed_at
    return Frames(
        time=motion.time,
        com=motion.com,
        body_position=body_position,
        body_wxyz=body_wxyz,
        inertia_axes=inertia_axes,
        inertia_wxyz=inertia_wxyz,
        yaw_wxyz=_headings(base),
        foot_position=motion.foot_position,
        stands=np.asarray(stands, dtype=np.bool_),
        # Arrows of no length where no file says how the feet push.
        foot_force=np.zeros_like(motion.foot_position) if force is None else force,
        pressed_at=motion.foot_position if pressed_at is None else pressed_at,
        weight=float(robot.mass * np.linalg.norm(robot.model.gravity.linear)),
        contact=np.asarray(motion.contact, dtype=np.bool_),
        contact_point=_contact_points(motion, body_position, body_wxyz),
        angular_momentum=motion.angular_momentum,
        held_arms=_with_held_arms(motion, base.as_matrix()) if robot.arms else None,
    )


def _with_held_arms(motion: WholeBodyMotion, base: Array) -> tuple[Array, Array]:
    """The ellipsoid of the whole body in the same postures, but for the arms."""
    robot, joints = motion.robot, motion.joint_position.copy()
    joints[:, robot.arm_joint_index] = robot.arm_angles
    _, inertia = momentum_and_inertia(
        robot, joints, np.zeros_like(joints), np.zeros((len(base), 3))
    )
    return ellipsoid(base @ inertia @ base.transpose(0, 2, 1), robot.mass, base)


def _contact_points(motion: WholeBodyMotion, body_position: Array, body_wxyz: Array) -> Array:
    """(F, L, c, 3) m: corners of the soles as the feet stand, however they are tilted."""
    robot = motion.robot
    if robot.file.foot.is_point:
        return motion.foot_position[:, :, None]
    points = []
    for leg in robot.legs:
        placement = robot.model.frames[leg.foot_frame_id].placement
        corners = robot.corners @ placement.rotation.T + placement.translation
        body = leg.joint_ids[-1] - 1
        turn = rotation_matrices(body_wxyz[:, body])
        points.append(body_position[:, body, None] + corners @ turn.transpose(0, 2, 1))
    return np.stack(points, axis=1)


def _headings(attitude: Rotation) -> Array:
    """Turns about the vertical that take x where `attitude` takes it, seen from above, (F, 4)."""
    x, y = attitude.apply([1.0, 0.0, 0.0])[:, :2].T
    wxyz: Array = Rotation.from_euler("z", np.arctan2(y, x)[:, None]).as_quat(scalar_first=True)
    return wxyz
