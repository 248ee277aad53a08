"""Kinematics and mass of a robot's legs, the base at rest: Pinocchio, posture by posture.

Everything is in the base frame and in SI units. Leading dimensions of joint angles are arbitrary:
(..., L, n), L legs of n joints each.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array, BoolArray, IntArray
from llsrbm.mechanics import apply, cross, rotation_vectors

# m: a sole's turn counts in inverse kinematics as what it moves a point at this distance, which is
# about where the corners are.
TURN_ARM = 0.1
# Inverse kinematics:
_EXACT, _ITERATIONS, _LONGEST_STEP = 1e-10, 60, 0.12  # m, of an error; steps; m a step


@dataclass(frozen=True, eq=False)
class LegMotion:
    """Feet and CoM in a posture, and what the joints do to them.

    Attributes:
        foot: (..., L, 3) m; foot_rotation: (..., L, 3, 3) R_base_foot, None unless wanted.
        foot_jacobian, foot_turning: (..., L, 3, n) the foot's velocity and angular velocity per
            joint speed.
        com: (..., 3) m, of the whole robot; com_jacobian: (..., L, 3, n) its velocity per speed of
            a leg's joints; com_jacobian_all: (..., 3, J) of all joints'.
    """

    foot: Array
    foot_rotation: Array | None
    foot_jacobian: Array
    foot_turning: Array
    com: Array
    com_jacobian: Array
    com_jacobian_all: Array


@dataclass(frozen=True, eq=False)
class LegMasses:
    """Mass properties of the legs in a posture.

    Attributes:
        com: (..., L, 3) m, of each leg; com_jacobian: (..., L, 3, n) per joint speed.
        inertia: (..., L, 3, 3) kg m2 of each leg about its CoM.
        spin: (..., L, 3, n) kg m2: angular momentum of the leg's links about the leg's CoM per
            joint speed.
    """

    com: Array
    com_jacobian: Array
    inertia: Array
    spin: Array


@dataclass(frozen=True, eq=False)
class LegChains:
    """L legs of n joints each.

    Attributes:
        model: Pinocchio's, on a free flyer.
        joint_ids: (L, n) of the model's joints, from the base outwards.
        foot_ids: (L,) of the feet's frames.
        rest: (nq,) posture in which joints of no leg are where nothing else is said; None: at zero.
    """

    model: pin.Model
    joint_ids: IntArray
    foot_ids: tuple[int, ...]
    rest: Array | None = None

    @cached_property
    def prismatic(self) -> BoolArray:
        """(n,) whether the joint slides, the same for every leg."""
        kinds = [self.model.joints[j].shortname() for j in self.joint_ids[0].tolist()]
        return np.array([kind.startswith("JointModelP") for kind in kinds])

    @cached_property
    def mass(self) -> Array:
        """(L,) kg: mass of each leg."""
        masses = [[self.model.inertias[j].mass for j in leg] for leg in self.joint_ids.tolist()]
        return np.sum(masses, axis=1)

    @cached_property
    def _index(self) -> IntArray:
        """(L, n) of the joints among all velocities."""
        ids = self.joint_ids.tolist()
        return np.array([[self.model.joints[j].idx_v for j in leg] for leg in ids])

    def _read(
        self, q: Array, read: Callable[[pin.Data], Any], joints: Array | None = None
    ) -> list[Array]:
        """As `read_postures`, at joint angles q (..., L, n), the base at the origin.

        `joints`: (..., J) of all, where those of no leg are not at rest.
        """
        rest = pin.neutral(self.model) if self.rest is None else self.rest
        every = np.tile(rest, (q.size // self._index.size, 1))
        if joints is not None:
            every[:, 7:] = joints.reshape(len(every), -1)
        every[:, self._index + 1] = q.reshape(-1, *self._index.shape)  # a quaternion has 4 numbers
        arrays = read_postures(self.model, every, read)
        return [array.reshape(*q.shape[:-2], *array.shape[1:]) for array in arrays]

    def motion(
        self, q: Array, *, rotations: bool = False, joints: Array | None = None
    ) -> LegMotion:
        """Feet and CoM at joint angles q (..., L, n); `rotations`: with the feet's attitudes.

        `joints`: (..., J) of all, where those of no leg are not at rest.
        """
        J, momentum, com, *feet = self._read(
            q,
            lambda data: [
                data.J,
                data.Ag,
                data.com[0],
                *(data.oMf[frame].translation for frame in self.foot_ids),
                *(data.oMf[frame].rotation for frame in self.foot_ids if rotations),
            ],
            joints,
        )
        legs = len(self.foot_ids)
        foot = np.stack(feet[:legs], axis=-2)
        jacobian = self._of_legs(J)
        turning = jacobian[..., 3:, :]
        # Columns of J are velocities of the point at the origin.
        arm = cross(np.swapaxes(turning, -1, -2), foot[..., None, :])
        com_jacobian = momentum[..., :3, :] / pin.computeTotalMass(self.model)
        return LegMotion(
            foot=foot,
            foot_rotation=np.stack(feet[legs:], axis=-3) if rotations else None,
            foot_jacobian=jacobian[..., :3, :] + np.swapaxes(arm, -1, -2),
            foot_turning=turning,
            com=com,
            com_jacobian=self._of_legs(com_jacobian),
            com_jacobian_all=com_jacobian[..., 6:],
        )

    def masses(self, q: Array) -> LegMasses:
        """CoM, inertia and angular momentum of each leg at joint angles q (..., L, n)."""
        roots = self.joint_ids[:, 0].tolist()
        momentum, com, *bodies = self._read(
            q,
            lambda data: [
                data.Ag,
                data.com[0],
                *(data.oYcrb[root].lever for root in roots),
                *(partial(getattr, data.oYcrb[root], "inertia") for root in roots),
            ],
        )
        leg_com = np.stack(bodies[: len(roots)], axis=-2)
        # Momenta per joint speed: angular about the robot's CoM.
        columns = np.swapaxes(self._of_legs(momentum), -1, -2)
        arm = leg_com - com[..., None, :]
        spin = columns[..., 3:] - cross(arm[..., None, :], columns[..., :3])
        return LegMasses(
            com=leg_com,
            com_jacobian=np.swapaxes(columns[..., :3], -1, -2) / self.mass[:, None, None],
            inertia=np.stack(bodies[len(roots) :], axis=-3),
            spin=np.swapaxes(spin, -1, -2),
        )

    def origins(self, q: Array) -> Array:
        """(..., L, n, 3) m: origins of the joints at joint angles q (..., L, n)."""
        joints = self.joint_ids.ravel().tolist()
        places = self._read(q, lambda data: [data.oMi[joint].translation for joint in joints])
        return np.stack(places, axis=-2).reshape(*q.shape, 3)

    def _of_legs(self, columns: Array) -> Array:
        """(..., L, r, n) of matrices (..., r, nv)."""
        return np.moveaxis(columns[..., self._index], -3, -2)


def read_postures(
    model: pin.Model, q: Array, read: Callable[[pin.Data], Sequence[Array | Callable[[], Array]]]
) -> list[Array]:
    """Arrays (K, ...) of Pinocchio's data in K postures q (K, nq): kinematics, `ccrba`, frames.

    `read` gives the wanted arrays of a data object: views of its memory, so that reading one costs
    a copy and no more; or functions where there is no view.
    """
    data, rest = model.createData(), np.zeros(model.nv)
    views = read(data)
    kept = [np.empty((len(q), *np.shape(_value(view)))) for view in views]
    for k, posture in enumerate(q):
        pin.ccrba(model, data, posture, rest)
        pin.updateFramePlacements(model, data)
        for array, view in zip(kept, views, strict=True):
            array[k] = _value(view)
    return kept


def _value(view: Array | Callable[[], Array]) -> Array:
    return view() if callable(view) else view


def foot_task(
    motion: LegMotion, foot: Array, foot_rotation: Array | None = None
) -> tuple[Array, Array]:
    """Errors of the feet from their goals, base frame; r = 3, or 6 with rotations.

    Args:
        motion: the legs, with rotations where they matter.
        foot: (..., L, 3) m; foot_rotation: (..., L, 3, 3) R_base_foot, where it matters.

    Returns:
        error (..., L, r) m, rotations by TURN_ARM below; its Jacobian (..., L, r, n), sign changed.
    """
    error = foot - motion.foot
    if foot_rotation is None:
        return error, motion.foot_jacobian
    assert motion.foot_rotation is not None
    missing = foot_rotation @ np.swapaxes(motion.foot_rotation, -1, -2)
    turn = rotation_vectors(missing)
    return (
        np.concatenate([error, TURN_ARM * turn], axis=-1),
        np.concatenate([motion.foot_jacobian, TURN_ARM * motion.foot_turning], axis=-2),
    )


def solve_legs(
    chains: LegChains,
    foot: Array,
    q: Array,
    foot_rotation: Array | None = None,
) -> tuple[Array, Array]:
    """Inverse kinematics of each leg alone: feet at `foot` (..., L, 3) m, base frame.

    Starts at q (..., L, n) and moves each foot along a straight line, so that a leg stays on the
    side of its singularities on which it started. `foot_rotation`: as in `foot_task`.

    Returns:
        q (..., L, n) and the remaining error (..., L) m (a rotation's times TURN_ARM).
    """
    q = np.broadcast_to(q, (*foot.shape[:-1], q.shape[-1])).copy()
    turns = foot_rotation is not None
    error, jacobian = foot_task(chains.motion(q, rotations=turns), foot, foot_rotation)
    for _ in range(_ITERATIONS):
        if np.abs(error).max() < _EXACT:
            break
        q = q + apply(damped_inverse(jacobian, error), shortened(error))
        motion = chains.motion(q, rotations=turns)
        error, jacobian = foot_task(motion, foot, foot_rotation)
    return q, np.linalg.norm(error, axis=-1)


def shortened(error: Array) -> Array:
    """Task errors cut to a step that Newton's linearisation bears, m."""
    length = np.sqrt(np.sum(error * error, axis=-1, keepdims=True))
    return error * np.minimum(1.0, _LONGEST_STEP / np.maximum(length, 1e-12))


def damped_inverse(jacobian: Array, error: Array) -> Array:
    """J^T (J J^T + |e|^2 1)^-1, (..., n, r): undamped at the goal, bounded where there is none.

    Damping by the squared error keeps Newton's quadratic convergence and limits a step to half a
    radian at a singularity (T. Sugihara, IEEE T-RO 27(5), 2011).
    """
    transpose = np.swapaxes(jacobian, -1, -2)
    squared = np.minimum(np.sum(error * error, axis=-1), 1e-2) + 1e-12
    square = jacobian @ transpose
    return transpose @ np.linalg.inv(square + squared[..., None, None] * np.eye(square.shape[-1]))
