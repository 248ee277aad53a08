"""A plan between and at its knots: motion of the CoM, the base and the feet.

Of each interval between two knots the plan fixes the CoM's acceleration (forces are constant), the
turn of the base and the motion of the feet. From these follow velocities at the knots. They are
continuous: on both sides of lift-off and touchdown the feet are at rest in the world, at both ends
of the plan everything is. Elsewhere the base's rate and the flying feet's velocity at a knot are
the means of the two intervals beside it. At lift-off and touchdown the base's rate is extrapolated
from the side on which the feet stand: a plan's rates have a step there, because its feet move as
fast in the whole first interval of flight, and in the last.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from llsrbm.arrays import Array, BoolArray, IntArray
from llsrbm.mechanics import cross, rotation_matrices, slerp, turns_between
from llsrbm.request.schedule import Schedule
from llsrbm.robots.robot import Robot

_AT_REST = 1e-3  # m/s of the CoM: where a plan ends at rest, a solver is that far off


@dataclass(frozen=True, eq=False)
class KnotMotion:
    """A plan's motion at N + 1 knots; arrays as in `llsrbm.motion.plan.Plan`."""

    time: Array
    schedule: Schedule  # which feet stand in a phase
    phase: IntArray
    com: Array
    com_velocity: Array
    base_quat: Array
    foot_position: Array
    foot_quat: Array
    contact_point: Array
    contact_force: Array
    joint_position: Array | None = None  # (N+1, J) postures at the knots; None to have them solved

    @property
    def standing(self) -> BoolArray:
        """(N, L) whether a foot stands over an interval."""
        return self.schedule.stands[self.phase[:-1]]

    @staticmethod
    def of_plan(plan: Any) -> KnotMotion:
        """The knots of a plan, or of another object with these attributes, with its postures."""
        return KnotMotion(**{field.name: getattr(plan, field.name) for field in fields(KnotMotion)})


@dataclass(frozen=True, eq=False)
class States:
    """K instants, world frame."""

    com: Array  # (K, 3) m, m/s
    com_velocity: Array  # (K, 3) m, m/s
    base_quat: Array  # (K, 4)
    omega: Array  # (K, 3) rad/s, of the base
    foot: Array  # (K, L, 3) m, m/s
    foot_velocity: Array  # (K, L, 3) m, m/s
    foot_quat: Array | None = None  # (K, L, 4)
    foot_omega: Array | None = None  # (K, L, 3) rad/s; None of points


def states(robot: Robot, motion: KnotMotion) -> tuple[States, States]:
    """The N + 1 knots and the middles of the N intervals."""
    dt = np.diff(motion.time)
    rate = turns_between(motion.base_quat[:-1], motion.base_quat[1:]) / dt[:, None]
    # Flying feet are seen from the CoM in base axes, where they move on straight lines.
    seen = (motion.foot_position - motion.com[:, None]) @ rotation_matrices(motion.base_quat)
    seen_rate = np.diff(seen, axis=0) / dt[:, None, None]
    knots = _at_knots(motion, rate, seen_rate)
    middles = _in_the_middle(motion, rate, seen, seen_rate)
    if robot.foot_coordinates == 3:
        return knots, middles
    standing, feet = motion.standing, motion.foot_quat
    rests = standing[..., None]
    foot_rate = turns_between(feet[:-1], feet[1:]) / dt[:, None, None]
    flying = slerp(feet[:-1], feet[1:], np.array(0.5))
    return (
        replace(knots, foot_quat=feet, foot_omega=_flying(_means(foot_rate, dt), standing)),
        replace(
            middles,
            foot_quat=np.where(rests, feet[:-1], flying),
            foot_omega=np.where(rests, 0.0, foot_rate),
        ),
    )


def arm_rates(robot: Robot, motion: KnotMotion, joints: Array) -> tuple[Array, Array]:
    """Speeds of the arms' joints (N, A n) in the middles and (N+1, A n) at the knots, rad/s.

    `joints`: (N+1, J) rad at the knots, between which arms move evenly.
    """
    dt = np.diff(motion.time)
    rates = np.diff(joints[:, robot.arm_joint_index], axis=0) / dt[:, None]
    at_knots = _means(rates, dt)
    if np.linalg.norm(motion.com_velocity[0]) > _AT_REST:
        at_knots[0] = rates[0]
    return rates, at_knots


def _in_the_middle(motion: KnotMotion, rate: Array, seen: Array, seen_rate: Array) -> States:
    dt, v, rests = np.diff(motion.time), motion.com_velocity, motion.standing[..., None]
    quat = slerp(motion.base_quat[:-1], motion.base_quat[1:], np.array(0.5))
    R_world_base = rotation_matrices(quat)
    com = (motion.com[1:] + motion.com[:-1]) / 2 - np.diff(v, axis=0) * dt[:, None] / 8
    com_velocity = (v[1:] + v[:-1]) / 2
    lever = ((seen[1:] + seen[:-1]) / 2) @ np.swapaxes(R_world_base, -1, -2)
    foot_velocity = _foot_velocity(com_velocity, R_world_base, seen_rate, rate, lever)
    return States(
        com=com,
        com_velocity=com_velocity,
        base_quat=quat,
        omega=rate,
        foot=np.where(rests, motion.foot_position[:-1], com[:, None] + lever),
        foot_velocity=np.where(rests, 0.0, foot_velocity),
    )


def _at_knots(motion: KnotMotion, rate: Array, seen_rate: Array) -> States:
    dt, v, standing = np.diff(motion.time), motion.com_velocity, motion.standing
    omega = _base_rates(rate, dt, standing)
    for end in (0, -1):
        if np.linalg.norm(v[end]) > _AT_REST:  # of a run-up, or a landing that keeps some speed
            omega[end] = rate[end]
    R_world_base = rotation_matrices(motion.base_quat)
    lever = motion.foot_position - motion.com[:, None]
    seen_rate = _flying(_means(seen_rate, dt), standing)
    foot_velocity = _foot_velocity(v, R_world_base, seen_rate, omega, lever)
    return States(
        com=motion.com,
        com_velocity=v,
        base_quat=motion.base_quat,
        omega=omega,
        foot=motion.foot_position,
        foot_velocity=_flying(foot_velocity, standing),
    )


def _foot_velocity(
    com_velocity: Array, R_world_base: Array, seen_rate: Array, omega: Array, lever: Array
) -> Array:
    """(K, L, 3) m/s of feet at `lever` from the CoM that move by `seen_rate` in base axes."""
    turning = cross(np.broadcast_to(omega[:, None], lever.shape), lever)
    return com_velocity[:, None] + seen_rate @ np.swapaxes(R_world_base, -1, -2) + turning


def _means(rates: Array, dt: Array) -> Array:
    """Values (N+1, ...) at the knots of what (N, ...) holds in the middles; zero at both ends."""
    shaped = dt.reshape(-1, *[1] * (rates.ndim - 1))
    values = np.zeros((len(rates) + 1, *rates.shape[1:]))
    before, after = shaped[:-1], shaped[1:]
    values[1:-1] = (rates[:-1] * after + rates[1:] * before) / (before + after)
    return values


def _flying(values: Array, standing: BoolArray) -> Array:
    """Values (N+1, L, 3), zero at knots at which the foot stands just before or just after."""
    flying = np.zeros(values.shape[:2], dtype=bool)
    flying[1:-1] = ~standing[:-1] & ~standing[1:]
    return np.where(flying[..., None], values, 0.0)


def _base_rates(rate: Array, dt: Array, standing: BoolArray) -> Array:
    """(N+1, 3) rad/s at the knots, of (N, 3) over the intervals.

    Where feet leave or land, from the side on which more of them stand.
    """
    values = _means(rate, dt)
    for knot in np.flatnonzero((standing[1:] != standing[:-1]).any(axis=1)) + 1:
        lift_off = standing[knot - 1].sum() > standing[knot].sum()
        near, far = (knot - 1, knot - 2) if lift_off else (knot, knot + 1)
        values[knot] = rate[near]
        if 0 <= far < len(rate) and (standing[far] == standing[near]).all():
            share = dt[near] / (dt[near] + dt[far])
            values[knot] += (rate[near] - rate[far]) * share
    return values
