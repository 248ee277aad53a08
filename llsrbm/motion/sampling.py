"""Plans and rollouts at any time, each quantity as `llsrbm.files.quantity.Between` describes it.

Between its knots a plan follows from what the planner assumes there: contact forces are constant,
so the CoM is quadratic and the angular momentum cubic in time; the attitude turns at a constant
rate; feet that stand are still, the others move on straight lines seen from the CoM in base axes
and carry their contact points along. Between the ticks of a rollout states are straight.
Forces and torques of a refined plan are straight lines over two intervals at a time, through their
values in the middles of these: so at any instant they are what inverse dynamics gives.
Knots and ticks are reproduced exactly, but for these; quaternions come out without jumps of sign.
The whole body between a plan's knots, which exports and the certificate have, is
`llsrbm.motion.realised`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from functools import cached_property
from numbers import Real
from typing import Any, TypeVar

import numpy as np
from scipy.interpolate import Akima1DInterpolator, CubicHermiteSpline

from llsrbm.arrays import Array, BoolArray, IntArray
from llsrbm.errors import InputError
from llsrbm.files.quantity import TIME, Between, quantities
from llsrbm.mechanics import rotation_matrices, sign_continuous, slerp
from llsrbm.motion.curves import Polynomials
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout

FASTEST = 10_000.0  # frames/s; more is a mistyped number
LONGEST_PAD = 60.0  # s, likewise
_SAME_INSTANT = 1e-9  # s; a time that rounding puts before its tick belongs to the tick

_Trajectory = TypeVar("_Trajectory", bound=Plan | Rollout)


def events(trajectory: Plan | Rollout) -> Array:
    """First and last instant, and those between at which something changes at once, s.

    Of a plan the edges of its phases; of a rollout the ticks at which the controller changes phase
    or mode, and those in which a foot leaves the ground or meets it.
    """
    if isinstance(trajectory, Plan):
        return trajectory.phase_start
    states = np.column_stack([trajectory.phase, trajectory.mode, trajectory.contact])
    changed = np.flatnonzero((np.diff(states, axis=0) != 0).any(axis=1)) + 1
    ticks = np.unique(np.concatenate([[0], changed, [len(trajectory.time) - 1]]))
    return trajectory.time[ticks]


def with_events(trajectory: Plan | Rollout, fps: float) -> Array:
    """Instants 1/fps apart from the first to the last, and every event, in order, s. Raises
    `InputError`: `fps` is not a positive number up to 10000.
    """
    check_rate(fps)
    exact = events(trajectory)
    start, end = exact[0], exact[-1]
    times = start + np.arange(math.floor((end - start) * fps) + 1) / fps
    after = np.clip(np.searchsorted(exact, times), 1, len(exact) - 1)
    nearest = np.minimum(np.abs(times - exact[after - 1]), np.abs(times - exact[after]))
    apart = nearest > _SAME_INSTANT
    return np.unique(np.concatenate([times[apart], exact]))


def evenly(trajectory: Plan | Rollout, fps: float, pad: float = 0.0) -> Array:
    """Instants exactly 1/fps apart that hold the whole motion, s of the motion's own time.

    `pad`: s of standing still before and after, rounded up to whole frames. Raises `InputError`:
    `fps` is not a positive number up to 10000, or `pad` not one from 0 to 60 s.
    """
    check_rate(fps)
    if not (math.isfinite(pad) and 0 <= pad <= LONGEST_PAD):
        raise InputError(f"pad: expected 0 to {LONGEST_PAD:g} s of standing still, got {pad}")
    start, end = trajectory.time[[0, -1]]
    still = math.ceil(pad * fps - _SAME_INSTANT)
    moving = math.ceil((end - start) * fps - 1e-6)
    return start + np.arange(-still, moving + still + 1) / fps


def check_rate(fps: Any) -> None:
    """Raise `InputError` unless `fps` is a rate at which something can be sampled."""
    number = isinstance(fps, Real) and not isinstance(fps, bool)
    if not (number and math.isfinite(fps) and 0 < fps <= FASTEST):
        raise InputError(f"frames per second: expected 0 < fps <= {FASTEST:.0f}, got {fps!r:.40}")


def foothold_knots(plan: Plan) -> IntArray:
    """(K + 1, L) knots at which `foot_position` and `contact_point` hold the footholds of places.

    Place 0 is read where the plan starts, the others where their feet have stood longest. -1 where
    a foot never stands in a place.
    """
    schedule = plan.schedule
    ends = np.searchsorted(plan.time, plan.phase_start[1:] - 1e-9)
    knots = np.full((schedule.places + 1, len(schedule.legs)), -1, dtype=np.int64)
    for phase, end in zip(schedule, ends, strict=True):
        stands = [leg in phase.feet for leg in schedule.legs]
        knots[phase.place, stands] = 0 if phase.place == 0 else end
    return knots


def resample(trajectory: _Trajectory, times: Any) -> _Trajectory:
    """The trajectory with instants `times` (K,) s, in any order, in place of its knots or ticks.

    Before its start and after its end it stands still. At an instant where the phase changes, the
    phase that begins there counts. Velocities of the joints are always there afterwards. Raises
    `InputError`: a time is not finite.
    """
    values = sampled(trajectory, times, quantities(type(trajectory)))
    values["certificate"] = None  # of the motion as it was
    if isinstance(trajectory, Plan):
        values["solution"] = None  # is of the knots
    return replace(trajectory, **values)


def sampled(trajectory: Plan | Rollout, times: Any, names: Collection[str]) -> dict[str, Any]:
    """Some quantities of what `resample` makes, and `time`, by name; those over no time left out.
    Raises `InputError`: a time is not finite.
    """
    times = np.atleast_1d(np.asarray(times, dtype=np.float64))
    if times.ndim != 1 or not np.isfinite(times).all():
        raise InputError("times: expected a list of finite numbers, s")
    instants = Interpolation.of(trajectory.time, times)
    between = _BetweenKnots(trajectory, instants) if isinstance(trajectory, Plan) else None
    values: dict[str, Any] = {}
    for name, quantity in quantities(type(trajectory)).items():
        known = getattr(trajectory, name)
        if name not in names or TIME not in quantity.axes:
            continue
        if known is None and quantity.between is not Between.JOINT_RATES:
            continue
        if between is not None and quantity.between in between.rules:
            values[name] = between.rules[quantity.between](name)
        else:
            values[name] = _RULES[quantity.between](instants, known)
        if between is not None and name in between.lines:
            values[name] = between.lines[name]
        elif known is not None and quantity.between not in (Between.TURNING, Between.POSE):
            # Free of rounding, and of the solver's defects.
            values[name][instants.exact] = known[instants.at[instants.exact]]
        if quantity.rate:
            values[name][instants.outside] = 0.0
    values["time"] = times
    return values


@dataclass(frozen=True, eq=False)
class Interpolation:
    """Where K instants lie among knots or ticks.

    Attributes:
        time: (K,) s, within the motion; outside: (K,) whether it had to be moved there.
        at: (K,) the last knot that is not later; exact: (K,) whether it is at that very time.
        left: (K,) the knot before, the last one excepted; share: (K,) of the way to the next.
    """

    time: Array
    outside: BoolArray
    at: IntArray
    exact: BoolArray
    left: IntArray
    share: Array

    @staticmethod
    def of(knots: Array, times: Array) -> Interpolation:
        """Places of instants (K,) s among knots or ticks, s."""
        inside = np.clip(times, knots[0], knots[-1])
        at = np.searchsorted(knots, inside + _SAME_INSTANT, side="right") - 1
        left = np.minimum(at, len(knots) - 2)
        share = np.clip((inside - knots[left]) / np.diff(knots)[left], 0.0, 1.0)
        exact = np.abs(knots[at] - inside) <= _SAME_INSTANT
        outside = np.abs(times - inside) > _SAME_INSTANT
        return Interpolation(inside, outside, at, exact, left, share)

    def weighted(self, factor: Array, values: Array) -> Array:
        """`values` (K, ...), each times its own of `factor` (K,)."""
        return factor.reshape(-1, *[1] * (values.ndim - 1)) * values

    def linear(self, values: Array) -> Array:
        """Straight between (N, ...) values at the knots."""
        a, b = values[self.left], values[self.left + 1]
        return a + self.weighted(self.share, b - a)

    def turning(self, quat: Array) -> Array:
        """Attitudes (N, ..., 4), turning at a constant rate."""
        quat = sign_continuous(quat)
        share = self.share.reshape(-1, *[1] * (quat.ndim - 2))
        return slerp(quat[self.left], quat[self.left + 1], share)

    def pose(self, qpos: Array) -> Array:
        """MuJoCo's coordinates (N, Q), straight, the base turning at a constant rate."""
        mixed = self.linear(qpos)
        mixed[:, 3:7] = self.turning(qpos[:, 3:7])
        return mixed


_RULES: dict[Between, Callable[[Interpolation, Any], Any]] = {
    Between.HELD: lambda instants, values: values[instants.at],
    Between.LINEAR: Interpolation.linear,
    Between.TURNING: Interpolation.turning,
    Between.POSE: Interpolation.pose,
}


class _BetweenKnots:
    """Rules between a plan's knots beyond those of any trajectory: `rules` by their names."""

    def __init__(self, plan: Plan, instants: Interpolation) -> None:
        self._plan, self._instants = plan, instants
        self.rules: dict[Between, Callable[[str], Any]] = {
            Between.BALLISTIC: self._ballistic,
            Between.FROM_COM: lambda name: self._from_com(getattr(plan, name)),
            Between.STANDING: self._standing,
            Between.CARRIED: lambda _: self._carried,
            Between.IN_BASE: self._in_base,
            Between.JOINTS: lambda _: self._joint_curve(instants.time),
            Between.JOINT_RATES: lambda _: self._joint_curve(instants.time, nu=1),
        }

    @cached_property
    def lines(self) -> dict[str, Array]:
        """Forces and torques of a refined plan, by their names."""
        plan, instants = self._plan, self._instants
        if not plan.refined:
            return {}
        pair = instants.left // 2
        share = instants.left % 2 + instants.share - 0.5
        found = {}
        for name in ("contact_force", "joint_torque"):
            at_nodes = getattr(plan, name)
            first, second = at_nodes[:-1:2][pair], at_nodes[1::2][pair]
            found[name] = first + instants.weighted(share, second - first)
        return found

    @cached_property
    def _R(self) -> Array:
        return rotation_matrices(self._instants.turning(self._plan.base_quat))

    @cached_property
    def _R_knots(self) -> Array:
        return rotation_matrices(self._plan.base_quat)

    @cached_property
    def _com(self) -> Array:
        return self._ballistic("com")

    def _ballistic(self, name: str) -> Array:
        plan, instants, values = self._plan, self._instants, getattr(self._plan, name)
        if name == "com":
            first, last = plan.com_velocity[:-1], plan.com_velocity[1:]
        else:
            force, points = plan.contact_force[:-1], plan.contact_point[:-1]
            first, last = (
                np.cross(points - com[:, None], force).sum(axis=1)
                for com in (plan.com[:-1], plan.com[1:])
            )
        curve = Polynomials.between(np.diff(values, axis=0), first, last, np.diff(plan.time))
        return curve.plus(values[:-1]).at(instants.left, instants.share)

    def _from_com(self, points: Array) -> Array:
        """Points (N, 3) or (N, n, 3), straight between knots seen from the CoM in base axes."""
        plan = self._plan
        many = points.reshape(len(points), -1, 3)
        seen = np.einsum("kji,knj->kni", self._R_knots, many - plan.com[:, None])
        back = np.einsum("kij,knj->kni", self._R, self._instants.linear(seen))
        return (self._com[:, None] + back).reshape(len(back), *points.shape[1:])

    def _standing(self, name: str) -> Array:
        points = getattr(self._plan, name)
        stands = self._plan.contact[self._instants.left]
        still = self._instants.linear(points)
        return np.where(stands[:, :, None], still, self._from_com(points))

    @cached_property
    def _carried(self) -> Array:
        """Contact points (K, C, 3) of the feet where they are."""
        plan = self._plan
        foot_position = self._standing("foot_position")
        foot_quat = self._instants.turning(plan.foot_quat)
        count, legs = foot_position.shape[:2]
        at_knots = plan.contact_point.reshape(len(plan.time), legs, -1, 3)
        # The same at all knots, but for balls, which touch a slope beside their lowest points.
        levers = at_knots - plan.foot_position[:, :, None]
        in_foot = self._instants.linear(levers @ rotation_matrices(plan.foot_quat))
        turned = in_foot @ np.swapaxes(rotation_matrices(foot_quat), -1, -2)
        points: Array = foot_position[:, :, None] + turned
        return points.reshape(count, -1, 3)

    def _in_base(self, name: str) -> Array:
        in_base = np.einsum(
            "kai,kab,kbj->kij", self._R_knots, getattr(self._plan, name), self._R_knots
        )
        return np.einsum("kia,kab,kjb->kij", self._R, self._instants.linear(in_base), self._R)

    @cached_property
    def _joint_curve(self) -> Callable[..., Array]:
        """Through the knots with the joints' own velocities there, so nothing is a difference
        across lift-off or touchdown.

        Between knots the feet of ANYmal's posture stay within about 5 mm of `foot_position`, a
        tenth of that outside the first and last interval of flight: the planner's feet change their
        speed at knots, joints here do not.
        """
        plan = self._plan
        if plan.joint_velocity is None:
            # Local, so that lift-off and touchdown do not ring through.
            return Akima1DInterpolator(plan.time, plan.joint_position, method="makima")
        return CubicHermiteSpline(plan.time, plan.joint_position, plan.joint_velocity)
