"""A plan at any time: what a player draws and an export writes, from the knots.

Between knots every quantity follows from what the planner assumes there: contact forces are
constant, so the CoM is quadratic and the angular momentum cubic in time; the attitude turns at a
constant rate; in stance the feet stand still, in flight they move on straight lines seen from the
CoM in base axes and carry their contact points along. Knots are reproduced exactly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import Akima1DInterpolator

from llsrbm.errors import InputError
from llsrbm.motion.plan import Phase, Plan
from llsrbm.motion.rotation import rotation_matrices, sign_continuous, slerp

Array = NDArray[np.float64]

_FASTEST = 10_000.0  # frames/s; more is a mistyped number
_SAME_INSTANT = 1e-9  # s

_RATES = (
    "com_velocity",
    "angular_velocity",
    "linear_momentum",
    "angular_momentum",
    "joint_velocity",
)


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion at K instants: L legs, C contacts, J joints; world frame, SI units.

    Attributes:
        time: (K,) s; phase: (K,) `llsrbm.motion.plan.Phase`.
        com, com_velocity: (K, 3) m, m/s.
        base_quat: (K, 4) w, x, y, z, without jumps of sign; base_position: (K, 3) m.
        angular_velocity: (K, 3) rad/s of the base.
        linear_momentum, angular_momentum: (K, 3) kg m/s, kg m2/s (about the CoM).
        inertia: (K, 3, 3) kg m2: the model's centroidal inertia.
        foot_position: (K, L, 3) m; foot_quat: (K, L, 4) w, x, y, z.
        contact_point: (K, C, 3) m; contact_force: (K, C, 3) N, zero in flight.
        leg_com: (K, L, 3) m: where the model puts each leg's mass.
        joint_position, joint_velocity: (K, J) rad or m, and per second.
        joint_torque, joint_torque_limit: (K, J) Nm or N, constant over the plan's intervals; None
            where the plan has none.
        joint_names: (J,).
    """

    time: Array
    phase: NDArray[np.int64]
    com: Array
    com_velocity: Array
    base_quat: Array
    base_position: Array
    angular_velocity: Array
    linear_momentum: Array
    angular_momentum: Array
    inertia: Array
    foot_position: Array
    foot_quat: Array
    contact_point: Array
    contact_force: Array
    leg_com: Array
    joint_position: Array
    joint_velocity: Array
    joint_torque: Array | None
    joint_torque_limit: Array | None
    joint_names: tuple[str, ...]


def uniform_times(plan: Plan, fps: float, *, phase_edges: bool = False) -> Array:
    """Instants 1/fps apart from the plan's first to its last, both included.

    The last step is shorter when the duration is no multiple of 1/fps.

    Args:
        phase_edges: include the instants of lift-off and touch-down exactly.

    Raises:
        InputError: `fps` is not a positive number up to 10000.
    """
    return frame_times(plan.phase_start if phase_edges else plan.time[[0, -1]], fps)


def frame_times(exact: Array, fps: float) -> Array:
    """Instants 1/fps apart from the first of `exact`, and those of `exact`, in order, s.

    Args:
        exact: increasing; the last one ends the frames.

    Raises:
        InputError: `fps` is not a positive number up to 10000.
    """
    if not (math.isfinite(fps) and 0 < fps <= _FASTEST):
        raise InputError(f"frames per second: expected 0 < fps <= {_FASTEST:.0f}, got {fps}")
    start, end = exact[0], exact[-1]
    times = start + np.arange(math.floor((end - start) * fps) + 1) / fps
    apart = np.abs(times[:, None] - exact).min(axis=1) > _SAME_INSTANT
    return np.unique(np.concatenate([times[apart], exact]))


def resample(plan: Plan, times: Array) -> Motion:
    """The plan at `times` (K,) s, in any order; before its start and after its end it stands still.

    At a knot where the phase changes, the phase that begins there counts.

    Raises:
        InputError: a time is not finite.
    """
    times = np.atleast_1d(np.asarray(times, dtype=np.float64))
    if times.ndim != 1 or not np.isfinite(times).all():
        raise InputError("times: expected a list of finite numbers, s")
    inside = np.clip(times, plan.time[0], plan.time[-1])
    knot = np.searchsorted(plan.time, inside, side="right") - 1
    left = np.minimum(knot, len(plan.time) - 2)
    dt = np.diff(plan.time)[left]
    share = (inside - plan.time[left]) / dt
    between = _Between(left, share, dt)

    quats = sign_continuous(plan.base_quat)
    quat = slerp(quats[left], quats[left + 1], share)
    R, R_knots = rotation_matrices(quat), rotation_matrices(quats)
    com = between.cubic(plan.com, plan.com_velocity[left], plan.com_velocity[left + 1])

    def from_com(points: Array) -> Array:
        """Points (N+1, n, 3), straight between knots when seen from the CoM in base axes."""
        seen = np.einsum("kji,knj->kni", R_knots, points - plan.com[:, None])
        return com[:, None] + np.einsum("kij,knj->kni", R, between.linear(seen))

    def standing(points: Array) -> Array:
        """Points that stand still in the world, except in flight."""
        flight = (plan.phase[left] == Phase.FLIGHT)[:, None, None]
        return np.where(flight, from_com(points), between.linear(points))

    force = plan.contact_force
    moment_start = _moment(plan.contact_point[left], plan.com[left], force[left])
    moment_end = _moment(plan.contact_point[left], plan.com[left + 1], force[left])
    inertia_base = np.einsum("kai,kab,kbj->kij", R_knots, plan.inertia, R_knots)
    joints = _joint_curve(plan)
    feet = sign_continuous(plan.foot_quat)
    foot_quat = slerp(feet[left], feet[left + 1], share[:, None])
    foot_position = standing(plan.foot_position)
    motion = Motion(
        time=times,
        phase=plan.phase[knot],
        com=com,
        com_velocity=between.linear(plan.com_velocity),
        base_quat=quat,
        base_position=from_com(plan.base_position[:, None])[:, 0],
        angular_velocity=between.linear(plan.angular_velocity),
        linear_momentum=between.linear(plan.linear_momentum),
        angular_momentum=between.cubic(plan.angular_momentum, moment_start, moment_end),
        inertia=np.einsum("kia,kab,kjb->kij", R, between.linear(inertia_base), R),
        foot_position=foot_position,
        foot_quat=foot_quat,
        contact_point=_carried(plan, foot_position, foot_quat),
        contact_force=force[knot],
        leg_com=from_com(plan.leg_com),
        joint_position=joints(inside),
        joint_velocity=joints(inside, nu=1),
        joint_torque=None if plan.joint_torque is None else plan.joint_torque[knot],
        joint_torque_limit=(
            None if plan.joint_torque_limit is None else plan.joint_torque_limit[knot]
        ),
        joint_names=plan.joint_names,
    )
    _restore_knots(motion, plan, knot, inside)
    for name in _RATES:
        getattr(motion, name)[times != inside] = 0.0
    return motion


def _carried(plan: Plan, foot_position: Array, foot_quat: Array) -> Array:
    """Contact points (K, C, 3) of feet at places (K, L, 3) and attitudes (K, L, 4)."""
    count, legs = foot_position.shape[:2]
    levers = plan.contact_point[0].reshape(legs, -1, 3) - plan.foot_position[0][:, None]
    in_foot = levers @ rotation_matrices(plan.foot_quat[0])
    turned = in_foot @ np.swapaxes(rotation_matrices(foot_quat), -1, -2)
    points: Array = foot_position[:, :, None] + turned
    return points.reshape(count, -1, 3)


@dataclass(frozen=True)
class _Between:
    """Where K instants lie: `share` (K,) of the way through the interval after knot `left` (K,)."""

    left: NDArray[np.int64]
    share: Array
    dt: Array

    def _of(self, factor: Array, values: Array) -> Array:
        shaped: Array = factor.reshape(-1, *[1] * (values.ndim - 1)) * values
        return shaped

    def linear(self, values: Array) -> Array:
        """`values` (N+1, ...) at the instants."""
        a, b = values[self.left], values[self.left + 1]
        return a + self._of(self.share, b - a)

    def cubic(self, values: Array, slope_start: Array, slope_end: Array) -> Array:
        """`values` (N+1, n) with the slopes (K, n) at both ends of each instant's interval."""
        a, b = values[self.left], values[self.left + 1]
        s = self.share
        return (
            a
            + self._of(s * s * (3 - 2 * s), b - a)
            + self._of(self.dt * s * (1 - s) ** 2, slope_start)
            + self._of(self.dt * s * s * (s - 1), slope_end)
        )


def _moment(points: Array, com: Array, forces: Array) -> Array:
    """Of contact forces about the CoM, (K, 3) Nm."""
    total: Array = np.cross(points - com[:, None], forces).sum(axis=1)
    return total


def _joint_curve(plan: Plan) -> Akima1DInterpolator:
    """Smooth through the knots; local, so that lift-off and touch-down do not ring through.

    Between knots the feet of ANYmal's posture stay within about 5 mm of `foot_position` (10 mm on
    the longest twisting jumps): the planner's feet change their speed at knots, joints here do not.
    """
    return Akima1DInterpolator(plan.time, plan.joint_position, method="makima")


def _restore_knots(motion: Motion, plan: Plan, knot: NDArray[np.int64], inside: Array) -> None:
    """Put the plan's own numbers where an instant is a knot, free of rounding and of defects."""
    at = plan.time[knot] == inside
    for name in (
        "com",
        "com_velocity",
        "base_position",
        "angular_velocity",
        "linear_momentum",
        "angular_momentum",
        "inertia",
        "foot_position",
        "contact_point",
        "leg_com",
        "joint_position",
    ):
        getattr(motion, name)[at] = getattr(plan, name)[knot[at]]
