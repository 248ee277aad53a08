"""Instants of a motion, ready to be drawn: computed once for all of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from llsrbm.motion.plan import Phase
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.robots.visuals import forward_kinematics

Array = NDArray[np.float64]

FRAME_RATE = 60.0
"""Frames/s of motion; browsers mix neighbouring ones at lower speeds."""


@dataclass(frozen=True, eq=False)
class Frames:
    """F instants of a robot in motion, world frame: B bodies, L feet.

    Attributes:
        time: (F,) s.
        com: (F, 3) m.
        body_position: (F, B, 3) m and body_wxyz: (F, B, 4): pose of every moving body.
        inertia_axes: (F, 3) m and inertia_wxyz: (F, 4): ellipsoid of the inertia about the CoM.
        yaw_wxyz: (F, 4): the base's heading alone.
        foot_position: (F, L, 3) m.
        flight: (F,) whether in flight.
        foot_force: (F, L, 3) N: the sum over a foot's contacts.
        pressed_at: (F, L, 3) m: where it acts, a sole's centre of pressure.
        weight: of the robot, N.
    """

    time: Array
    com: Array
    body_position: Array
    body_wxyz: Array
    inertia_axes: Array
    inertia_wxyz: Array
    yaw_wxyz: Array
    foot_position: Array
    flight: NDArray[np.bool_]
    foot_force: Array
    pressed_at: Array
    weight: float

    @property
    def end(self) -> float:
        """Time of the last frame, s."""
        return float(self.time[-1])


def make_frames(motion: WholeBodyMotion) -> Frames:
    """Frames at the instants of a motion, whatever it comes from."""
    robot = motion.robot
    body_position, body_wxyz = forward_kinematics(
        robot, motion.base_position, motion.base_quat, motion.joint_position
    )
    base = Rotation.from_quat(motion.base_quat, scalar_first=True)
    inertia_axes, inertia_wxyz = ellipsoid(motion.inertia, robot.mass, base.as_matrix())
    flying = ~motion.contact.any(axis=1)
    flight = flying if motion.phase is None else motion.phase == Phase.FLIGHT
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
        flight=np.asarray(flight, dtype=np.bool_),
        # Arrows of no length where no file says how the feet push.
        foot_force=np.zeros_like(motion.foot_position) if force is None else force,
        pressed_at=motion.foot_position if pressed_at is None else pressed_at,
        weight=float(robot.mass * np.linalg.norm(robot.model.gravity.linear)),
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
