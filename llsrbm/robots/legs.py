"""Kinematics and mass of all legs of a robot, over many postures at once.

Pinocchio takes one posture a call; a plan has fifty and a fit has thousands. Everything here is in
the base frame and in SI units. Leading dimensions of joint angles are arbitrary: (..., L, n).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from llsrbm.mechanics import apply, cross, parallel_axis, skew

Array = NDArray[np.float64]

# m: a sole's turn counts in inverse kinematics as what it moves a point at this distance, which is
# about where the corners are.
TURN_ARM = 0.1


@dataclass(frozen=True, eq=False)
class LegMotion:
    """The legs in a posture, base frame.

    Attributes:
        rotation: (..., L, n, 3, 3) R_base_link of each link.
        origin: (..., L, n, 3) m: origin of each joint.
        foot: (..., L, 3) m.
        com: (..., L, 3) m: CoM of each leg's links.
        foot_jacobian, com_jacobian: (..., L, 3, n) with respect to the joint angles.
    """

    rotation: Array
    origin: Array
    foot: Array
    com: Array
    foot_jacobian: Array
    com_jacobian: Array


@dataclass(frozen=True, eq=False)
class LegChains:
    """Constants of L legs of n joints each.

    Attributes:
        placement_rotation, placement_origin: (L, n, 3, 3), (L, n, 3): each joint in the one before.
        axis: (L, n, 3) unit axis in the joint's own frame.
        prismatic: (n,) whether the joint slides, the same for every leg.
        foot_offset: (L, 3) m: the foot frame's origin in the last joint's frame.
        foot_rotation: (L, 3, 3) of the foot frame in the last joint's frame.
        link_mass: (L, n) kg; link_com: (L, n, 3) m; link_inertia: (L, n, 3, 3) kg m2 about its CoM;
            all in the joint's frame.
    """

    placement_rotation: Array
    placement_origin: Array
    axis: Array
    prismatic: NDArray[np.bool_]
    foot_offset: Array
    foot_rotation: Array
    link_mass: Array
    link_com: Array
    link_inertia: Array

    @staticmethod
    def from_model(
        model: pin.Model, joint_ids: list[list[int]], foot_frame_ids: list[int]
    ) -> LegChains:
        """Read the constants out of a Pinocchio model; joints from the base outwards."""
        subspace = [
            [np.asarray(model.joints[j].createData().S).reshape(6) for j in leg]
            for leg in joint_ids
        ]
        motion = np.array(subspace, dtype=float)
        prismatic = np.linalg.norm(motion[..., :3], axis=-1) > 0.5
        return LegChains(
            placement_rotation=np.array(
                [[model.jointPlacements[j].rotation for j in leg] for leg in joint_ids]
            ),
            placement_origin=np.array(
                [[model.jointPlacements[j].translation for j in leg] for leg in joint_ids]
            ),
            axis=np.where(prismatic[..., None], motion[..., :3], motion[..., 3:]),
            prismatic=prismatic[0],
            foot_offset=np.array([model.frames[f].placement.translation for f in foot_frame_ids]),
            foot_rotation=np.array([model.frames[f].placement.rotation for f in foot_frame_ids]),
            link_mass=np.array([[model.inertias[j].mass for j in leg] for leg in joint_ids]),
            link_com=np.array([[model.inertias[j].lever for j in leg] for leg in joint_ids]),
            link_inertia=np.array([[model.inertias[j].inertia for j in leg] for leg in joint_ids]),
        )

    @cached_property
    def mass(self) -> Array:
        """(L,) kg: mass of each leg."""
        return self.link_mass.sum(axis=1)

    @cached_property
    def _turning(self) -> tuple[Array, Array, Array]:
        """Constant, sine and cosine parts of Rodrigues' formula after the placement."""
        k = skew(self.axis)
        kk = k @ k
        placement = self.placement_rotation
        return placement + placement @ kk, placement @ k, -placement @ kk

    @cached_property
    def _moment(self) -> Array:
        """(L, n, 3) kg m: m c of each link in its own frame, foot excluded."""
        return self.link_mass[..., None] * self.link_com

    @cached_property
    def _outer_mass(self) -> Array:
        """(L, n) kg: mass of each link and all links beyond it."""
        return np.cumsum(self.link_mass[:, ::-1], axis=1)[:, ::-1]

    def frames(self, q: Array) -> tuple[Array, Array]:
        """R_base_link (..., L, n, 3, 3) and origin (..., L, n, 3) m of each joint frame."""
        constant, sine_part, cosine_part = self._turning
        sine, cosine = np.sin(q)[..., None, None], np.cos(q)[..., None, None]
        rotation = np.empty((*q.shape, 3, 3))
        origin = np.empty((*q.shape, 3))
        for j in range(q.shape[-1]):
            if self.prismatic[j]:
                turn = np.broadcast_to(self.placement_rotation[:, j], rotation[..., j, :, :].shape)
                shift = self.placement_origin[:, j] + q[..., j, None] * apply(
                    self.placement_rotation[:, j], self.axis[:, j]
                )
            else:
                turn = (
                    constant[:, j]
                    + sine[..., j, :, :] * sine_part[:, j]
                    + cosine[..., j, :, :] * cosine_part[:, j]
                )
                shift = self.placement_origin[:, j]
            if j == 0:
                rotation[..., 0, :, :], origin[..., 0, :] = turn, shift
            else:
                parent = rotation[..., j - 1, :, :]
                rotation[..., j, :, :] = parent @ turn
                origin[..., j, :] = origin[..., j - 1, :] + apply(parent, shift)
        return rotation, origin

    def motion(self, q: Array) -> LegMotion:
        """Feet, leg CoMs and their Jacobians at joint angles q (..., L, n)."""
        rotation, origin = self.frames(q)
        axis = apply(rotation, self.axis)
        foot = origin[..., -1, :] + apply(rotation[..., -1, :, :], self.foot_offset)
        moment = self.link_mass[..., None] * origin + apply(rotation, self._moment)
        outer_moment = np.cumsum(moment[..., ::-1, :], axis=-2)[..., ::-1, :]
        outer = self._outer_mass[..., None]
        total = self.mass[:, None]
        foot_jacobian = cross(axis, foot[..., None, :] - origin)
        com_jacobian = cross(axis, outer_moment - outer * origin)
        for j in np.flatnonzero(self.prismatic):
            foot_jacobian[..., j, :] = axis[..., j, :]
            com_jacobian[..., j, :] = outer[:, j] * axis[..., j, :]
        return LegMotion(
            rotation=rotation,
            origin=origin,
            foot=foot,
            com=outer_moment[..., 0, :] / total,
            foot_jacobian=np.swapaxes(foot_jacobian, -1, -2),
            com_jacobian=np.swapaxes(com_jacobian / total[..., None], -1, -2),
        )

    def foot_turning(self, motion: LegMotion) -> tuple[Array, Array]:
        """How the feet's frames stand and turn.

        Returns:
            rotation: (..., L, 3, 3) R_base_foot.
            jacobian: (..., L, 3, n): the foot's angular velocity relative to the base per joint
                speed, base axes.
        """
        axis = apply(motion.rotation, self.axis)
        axis[..., self.prismatic, :] = 0.0
        return motion.rotation[..., -1, :, :] @ self.foot_rotation, np.swapaxes(axis, -1, -2)

    def inertia_and_spin(self, motion: LegMotion) -> tuple[Array, Array]:
        """What a leg's extent adds to its point mass, in base axes.

        Returns:
            inertia: (..., L, 3, 3) kg m2 of the leg about its own CoM.
            spin: (..., L, 3, n) kg m2: angular momentum of the leg's links about the leg's CoM per
                joint speed, base at rest.
        """
        rotation, origin = motion.rotation, motion.origin
        link_inertia = rotation @ self.link_inertia @ np.swapaxes(rotation, -1, -2)
        lever = origin + apply(rotation, self.link_com) - motion.com[..., None, :]
        inertia = np.sum(
            link_inertia + self.link_mass[..., None, None] * parallel_axis(lever), axis=-3
        )
        axis = apply(rotation, self.axis)
        spin = np.zeros((*motion.foot.shape, axis.shape[-2]))
        for j in range(axis.shape[-2]):
            for k in range(j, axis.shape[-2]):
                a = axis[..., j, :]
                mass = self.link_mass[:, k, None]
                if self.prismatic[j]:
                    spin[..., j] += mass * cross(lever[..., k, :], a)
                else:
                    arm = lever[..., k, :] + motion.com - origin[..., j, :]
                    spin[..., j] += apply(link_inertia[..., k, :, :], a)
                    spin[..., j] += mass * cross(lever[..., k, :], cross(a, arm))
        return inertia, spin


def foot_task(
    chains: LegChains, motion: LegMotion, foot: Array, foot_rotation: Array | None = None
) -> tuple[Array, Array]:
    """What keeps the feet from where they shall be, base frame; r = 3, or 6 with rotations.

    Args:
        chains, motion: the legs.
        foot: (..., L, 3) m.
        foot_rotation: (..., L, 3, 3) R_base_foot, where it matters.

    Returns:
        error (..., L, r) m, rotations by TURN_ARM below; its Jacobian (..., L, r, n), sign changed.
    """
    error = foot - motion.foot
    if foot_rotation is None:
        return error, motion.foot_jacobian
    rotation, turning = chains.foot_turning(motion)
    missing = foot_rotation @ np.swapaxes(rotation, -1, -2)
    turn = Rotation.from_matrix(missing.reshape(-1, 3, 3)).as_rotvec().reshape(error.shape)
    return (
        np.concatenate([error, TURN_ARM * turn], axis=-1),
        np.concatenate([motion.foot_jacobian, TURN_ARM * turning], axis=-2),
    )


def solve_legs(
    chains: LegChains,
    foot: Array,
    q: Array,
    foot_rotation: Array | None = None,
    tolerance: float = 1e-10,
    iterations: int = 60,
) -> tuple[Array, Array]:
    """Inverse kinematics of each leg alone: feet at `foot` (..., L, 3) m, base frame.

    Starts at q (..., L, n) and moves each foot along a straight line, so that a leg stays on the
    side of its singularities on which it started.

    Args:
        chains, foot, q: see above.
        foot_rotation: (..., L, 3, 3) R_base_foot, where it matters.
        tolerance: m, when to stop.
        iterations: when to give up.

    Returns:
        q (..., L, n) and the remaining error (..., L) m (a rotation's times TURN_ARM).
    """
    q = np.broadcast_to(q, (*foot.shape[:-1], q.shape[-1])).copy()
    error, jacobian = foot_task(chains, chains.motion(q), foot, foot_rotation)
    for _ in range(iterations):
        if np.abs(error).max() < tolerance:
            break
        q = q + apply(damped_inverse(jacobian, error), shortened(error))
        error, jacobian = foot_task(chains, chains.motion(q), foot, foot_rotation)
    return q, np.linalg.norm(error, axis=-1)


def shortened(error: Array, longest: float = 0.12) -> Array:
    """Task errors cut to a step that Newton's linearisation bears, m."""
    length = np.sqrt(np.sum(error * error, axis=-1, keepdims=True))
    return error * np.minimum(1.0, longest / np.maximum(length, 1e-12))


def damped_inverse(jacobian: Array, error: Array) -> Array:
    """J^T (J J^T + |e|^2 1)^-1, (..., n, r): undamped at the goal, bounded where there is none.

    Damping by the squared error keeps Newton's quadratic convergence and limits a step to half a
    radian at a singularity (T. Sugihara, IEEE T-RO 27(5), 2011).
    """
    transpose = np.swapaxes(jacobian, -1, -2)
    squared = np.minimum(np.sum(error * error, axis=-1), 1e-2) + 1e-12
    square = jacobian @ transpose
    return transpose @ np.linalg.inv(square + squared[..., None, None] * np.eye(square.shape[-1]))
