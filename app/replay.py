"""A plan turned into frames: everything the scene draws, computed once for all instants."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from llsrbm.robots import Robot
from llsrbm.robots.visuals import forward_kinematics
from llsrbm.trajectory.plan import Phase, Plan
from llsrbm.trajectory.resample import Motion, resample, uniform_times

Array = NDArray[np.float64]

FRAME_RATE = 120.0
"""Frames/s of motion: enough for half speed at 60 Hz."""


@dataclass(frozen=True, eq=False)
class Replay:
    """F frames of a motion, world frame.

    Attributes:
        plan: where it comes from.
        motion: the plan at the frames' instants.
        body_position: (F, B, 3) m and body_wxyz: (F, B, 4): pose of every moving body.
        planned_axes: (F, 3) m and planned_wxyz: (F, 4): ellipsoid of the model's inertia.
        rigid_axes: (3,) m and rigid_wxyz: (F, 4): ellipsoid of the constant inertia that SRBM has.
        yaw_wxyz: (F, 4): the base's heading alone.
        weight: of the robot, N.
        interval: (F,) the plan's interval, over which contact forces are constant.
    """

    plan: Plan
    motion: Motion
    body_position: Array
    body_wxyz: Array
    planned_axes: Array
    planned_wxyz: Array
    rigid_axes: Array
    rigid_wxyz: Array
    yaw_wxyz: Array
    weight: float
    interval: NDArray[np.int64]

    def frame_at(self, time: float) -> int:
        """Index of the frame nearest to `time`, s."""
        times = self.motion.time
        after = int(np.searchsorted(times, time).clip(1, len(times) - 1))
        return after - 1 if time - times[after - 1] < times[after] - time else after

    @property
    def duration(self) -> float:
        """Length of the motion, s."""
        return self.plan.duration


@dataclass(frozen=True)
class Figures:
    """What the page tells about a plan.

    Attributes:
        duration: s.
        phase_durations: (take-off, flight, landing), s.
        peak_yaw_rate: largest |rotation rate about the vertical|, rad/s.
        smallest_Izz: in flight, kg m2.
        standing_Izz: of the default posture, kg m2.
        feet_radius: the feet's mean horizontal distance from the CoM where it is smallest in
            flight, m.
    """

    duration: float
    phase_durations: tuple[float, ...]
    peak_yaw_rate: float
    smallest_Izz: float
    standing_Izz: float
    feet_radius: float


def presentable(plan: Plan) -> bool:
    """Whether a plan can be drawn at all; a solver that diverged may leave anything."""
    arrays = (plan.time, plan.com, plan.base_quat, plan.joint_position, plan.inertia)
    return all(np.isfinite(a).all() for a in arrays) and bool((np.diff(plan.time) > 0).all())


def bake(plan: Plan, robot: Robot) -> Replay:
    """All frames of a plan; takes some milliseconds."""
    motion = resample(plan, uniform_times(plan, FRAME_RATE, phase_edges=True))
    body_position, body_wxyz = forward_kinematics(
        robot, motion.base_position, motion.base_quat, motion.joint_position
    )
    base = Rotation.from_quat(motion.base_quat, scalar_first=True)
    planned_axes, planned_wxyz = ellipsoid(motion.inertia, robot.mass, base.as_matrix())
    rigid_axes, rigid_turn = ellipsoid(robot.inertia[None], robot.mass, np.eye(3)[None])
    rigid = base * Rotation.from_quat(rigid_turn[0], scalar_first=True)
    last = len(plan.time) - 2
    return Replay(
        plan=plan,
        motion=motion,
        body_position=body_position,
        body_wxyz=body_wxyz,
        planned_axes=planned_axes,
        planned_wxyz=planned_wxyz,
        rigid_axes=rigid_axes[0],
        rigid_wxyz=rigid.as_quat(scalar_first=True),
        yaw_wxyz=_headings(base),
        weight=float(robot.mass * np.linalg.norm(robot.model.gravity.linear)),
        interval=np.searchsorted(plan.time, motion.time, side="right").clip(1, last + 1) - 1,
    )


def ellipsoid(inertia: Array, mass: float, reference: Array) -> tuple[Array, Array]:
    """The uniform solid ellipsoid that has this mass and this inertia.

    Its principal moments are I_i = m/5 (a_j^2 + a_k^2), so a_i = sqrt(5/(2m) (I_j + I_k - I_i)).

    Args:
        inertia: (K, 3, 3) kg m2.
        mass: kg.
        reference: (K, 3, 3) rotations; the axes are named so that axis i lies near its column i,
            or the ellipsoid's wireframe would jump whenever two principal moments cross.

    Returns:
        semi-axes (K, 3) m and attitude (K, 4) w, x, y, z.
    """
    moments, axes = np.linalg.eigh(inertia)
    likeness = np.abs(np.einsum("kji,kjl->kil", np.broadcast_to(reference, axes.shape), axes))
    order = _assignment(likeness)
    moments = np.take_along_axis(moments, order, axis=1)
    axes = np.take_along_axis(axes, order[:, None, :], axis=2)
    sign = np.sign(np.einsum("kji,kji->ki", np.broadcast_to(reference, axes.shape), axes))
    axes = axes * np.where(sign == 0, 1.0, sign)[:, None, :]
    axes[:, :, 2] *= np.sign(np.linalg.det(axes))[:, None]
    squares = 5 / (2 * mass) * (moments.sum(axis=1, keepdims=True) - 2 * moments)
    quaternion = Rotation.from_matrix(axes).as_quat(scalar_first=True)
    # A point mass model may violate the triangle inequality of moments by rounding.
    return np.sqrt(np.maximum(squares, 1e-6)), quaternion


def _headings(attitude: Rotation) -> Array:
    """Turns about the vertical that take x where `attitude` takes it, seen from above, (F, 4)."""
    x, y = attitude.apply([1.0, 0.0, 0.0])[:, :2].T
    wxyz: Array = Rotation.from_euler("z", np.arctan2(y, x)[:, None]).as_quat(scalar_first=True)
    return wxyz


_PERMUTATIONS = np.array([[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]])


def _assignment(likeness: Array) -> NDArray[np.int64]:
    """(K, 3): the permutation with the largest sum of likeness[k, i, order[i]]."""
    total = likeness[:, [0, 1, 2], _PERMUTATIONS].sum(axis=-1)
    best: NDArray[np.int64] = _PERMUTATIONS[np.argmax(total, axis=1)]
    return best


def figures(replay: Replay, robot: Robot) -> Figures:
    """The numbers under the sliders."""
    plan, motion = replay.plan, replay.motion
    flight = motion.phase == Phase.FLIGHT
    reach = np.linalg.norm((motion.foot_position - motion.com[:, None])[..., :2], axis=-1)
    return Figures(
        duration=plan.duration,
        phase_durations=tuple(np.diff(plan.phase_start).tolist()),
        peak_yaw_rate=float(np.abs(plan.angular_velocity[:, 2]).max()),
        smallest_Izz=float(motion.inertia[flight, 2, 2].min()),
        standing_Izz=float(robot.inertia[2, 2]),
        feet_radius=float(reach[flight].mean(axis=1).min()),
    )
