"""The whole body's motion that realises a plan, at any instant: what exports and checks have of it.

A plan's knots are postures; `llsrbm.motion.sampling` mixes its quantities between them as the
planner does, for which the base turns at steps of its rate. A body cannot. Between knots it moves

- its CoM as planned, exactly: a parabola over each interval;
- standing feet not at all, flying ones and the arms' joints along cubics that begin and end with
  the knots' velocities;
- its base such that the whole body, by Pinocchio, has the planned angular momentum. Where the
  model is wrong this turns it elsewhere than the next knot's attitude: a smooth rate, small and of
  the same integral, takes it there.

Its joints follow by inverse kinematics, their speeds by Jacobians. So at every instant inverse
dynamics needs nothing but the planned forces, but for the model's errors in the momentum's rate.

Over an interval of a refined plan joints and base follow from their states at its ends: cubics,
which is how the second stage has them.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from llsrbm.arrays import Array, IntArray
from llsrbm.body.knot_motion import KnotMotion, states
from llsrbm.body.momentum import base_velocities, centroidal_states, momentum_maps
from llsrbm.body.postures import joint_speeds, solve_postures
from llsrbm.mechanics import apply, interpolated, rotation_matrices, sign_continuous
from llsrbm.motion.curves import Polynomials, Turns, slope_of, turns
from llsrbm.motion.plan import Plan
from llsrbm.motion.sampling import Interpolation, resample, sampled
from llsrbm.robots.legs import LegMotion
from llsrbm.robots.robot import Robot

_AWAY = 5e-3  # m that feet and CoM may be off, of a plan whose postures are this robot's
_ITERATIONS = 4  # of Picard's; each takes the error down by an interval's turn, squared

# Instants of an interval at which the momentum is looked at, as shares of it.
_SHARES = np.linspace(0.0, 1.0, 4)
_COEFFICIENTS = np.linalg.inv(np.vander(_SHARES, increasing=True))  # of the polynomial through them
_ORDERS = np.arange(1, len(_SHARES) + 1)
# (4, 4): values at the shares -> integrals from 0 to each of them.
_INTEGRALS = (_SHARES[:, None] ** _ORDERS / _ORDERS) @ _COEFFICIENTS


def realised(plan: Plan, robot: Robot, times: Array) -> Plan:
    """`resample`, with the body that realises the plan; see the module.

    Of a plan that failed, or of which the robot has other legs by now, as `resample` has it.

    Args:
        plan: with the robot's joints, in any order.
        robot: that it is of, as it is now.
        times: (K,) s, in any order.

    Raises:
        InputError: a time is not finite.
    """
    plain = resample(plan, times)
    body = _body_that_fits(plan, robot)
    if body is None:
        return plain
    found: dict[str, Any] = body.at(Interpolation.of(plan.time, plain.time))
    back = [robot.joint_names.index(name) for name in plan.joint_names]
    for name in ("joint_position", "joint_velocity"):
        found[name] = found[name][:, back]
    return replace(plain, **found)


def realised_states(plan: Plan, robot: Robot, times: Array) -> tuple[Array, Array] | None:
    """Pinocchio's coordinates (K, nq) and velocities (K, nv) of a refined plan's body, joints in
    the robot's order, at times (K,) s; None of other plans, whose states `realised` has.
    """
    if not plan.refined or sorted(plan.joint_names) != sorted(robot.joint_names):
        return None
    body = _body_that_fits(plan, robot)
    if body is None:
        return None
    assert isinstance(body, _ByStates)
    return body.states(Interpolation.of(plan.time, times))


def _body_that_fits(plan: Plan, robot: Robot) -> _ByMomentum | _ByStates | None:
    if not plan.solved or plan.joint_velocity is None:
        return None
    body = _body(plan, robot)
    return body if body.fits else None


@lru_cache(maxsize=4)
def _body(plan: Plan, robot: Robot) -> _ByMomentum | _ByStates:
    return _ByStates(plan, robot) if plan.refined else _ByMomentum(plan, robot)


# ---- bodies


class _Body:
    """A plan's knots, joints in the robot's order."""

    def __init__(self, plan: Plan, robot: Robot) -> None:
        assert plan.joint_velocity is not None  # see `realised`
        order = [plan.joint_names.index(name) for name in robot.joint_names]
        self._plan, self._robot = plan, robot
        self._dt = np.diff(plan.time)
        self._quat = sign_continuous(plan.base_quat)
        self._joints, self._speeds = plan.joint_position[:, order], plan.joint_velocity[:, order]

    @cached_property
    def fits(self) -> bool:
        """True if the robot's feet and CoM are where the plan has them, in the plan's postures."""
        plan, robot = self._plan, self._robot
        legs = robot.chains.motion(self._joints[:, robot.leg_joint_index], joints=self._joints)
        R = rotation_matrices(plan.base_quat)
        base = plan.base_position[:, None]
        feet = base + legs.foot @ np.swapaxes(R, -1, -2) - [0.0, 0.0, robot.foot_lift]
        com = plan.base_position + apply(R, legs.com)
        missed = np.abs(feet - plan.foot_position).max(), np.abs(com - plan.com).max()
        return bool(max(missed) < _AWAY)

    def at(self, instants: Interpolation) -> dict[str, Array]:
        """Quantities of the plan at K instants, joints in the robot's order."""
        raise NotImplementedError


class _ByStates(_Body):
    """The body of a refined plan: straight accelerations over an interval."""

    def __init__(self, plan: Plan, robot: Robot) -> None:
        super().__init__(plan, robot)
        quat, q, v = self._quat, self._joints, self._speeds
        rate = apply(np.swapaxes(rotation_matrices(quat), -1, -2), plan.angular_velocity)
        velocity = base_velocities(robot, plan.com_velocity, plan.base_position, quat, rate, q, v)
        self._turns = Turns.through(quat, rate, self._dt)
        self._states = Polynomials.cubics(
            np.hstack([plan.base_position, q]), np.hstack([velocity, v]), self._dt
        )

    def states(self, instants: Interpolation) -> tuple[Array, Array]:
        """Pinocchio's coordinates (K, nq) and velocities (K, nv)."""
        k, share = instants.left, instants.share
        moving = ~instants.outside[:, None]
        quat, rate = self._turns.at(k, share)
        places, slopes = self._states.at(k, share), self._states.slopes(k, share) * moving
        velocity = apply(np.swapaxes(rotation_matrices(quat), -1, -2), slopes[:, :3])
        q = np.hstack([places[:, :3], quat[:, [1, 2, 3, 0]], places[:, 3:]])
        return q, np.hstack([velocity, rate * moving, slopes[:, 3:]])

    def at(self, instants: Interpolation) -> dict[str, Array]:
        q, v = self.states(instants)
        quat = q[:, [6, 3, 4, 5]]
        com, inertia, momentum = centroidal_states(self._robot.model, q, v)
        return {
            "com": com,
            "com_velocity": momentum[:, :3] / self._robot.mass,
            "base_quat": quat,
            "base_position": q[:, :3],
            "angular_velocity": apply(rotation_matrices(quat), v[:, 3:6]),
            "linear_momentum": momentum[:, :3],
            "angular_momentum": momentum[:, 3:],
            "inertia": inertia,
            "joint_position": q[:, 7:],
            "joint_velocity": v[:, 6:],
        }


class _Feet(NamedTuple):
    """Feet at K instants, world frame."""

    place: Array  # (K, L, 3) m
    quat: Array  # (K, L, 4)
    velocity: Array  # (K, L, 3) m/s
    omega: Array | None  # (K, L, 3) rad/s; None of points


class _ByMomentum(_Body):
    """The body of a plan of the first stage: its momentum is the planned one."""

    def __init__(self, plan: Plan, robot: Robot) -> None:
        super().__init__(plan, robot)
        motion = KnotMotion.of_plan(plan)
        self._knots, self._standing = states(robot, motion)[0], motion.standing
        feet = plan.foot_position, self._knots.foot_velocity
        self._places = Polynomials.cubics(*feet, self._dt)
        arms = robot.arm_joint_index
        self._arms = Polynomials.cubics(self._joints[:, arms], self._speeds[:, arms], self._dt)
        self._soles: Turns | None = None
        if self._knots.foot_omega is not None:
            quat = sign_continuous(plan.foot_quat)
            back = np.swapaxes(rotation_matrices(quat), -1, -2)
            self._soles = Turns.through(quat, apply(back, self._knots.foot_omega), self._dt)

    @cached_property
    def _base(self) -> Turns:
        """The base's attitude over each interval."""
        dt, quat = self._dt, self._quat
        back = np.swapaxes(rotation_matrices(quat), -1, -2)
        guess = Turns.through(quat, apply(back, self._knots.omega), dt)
        count = len(_SHARES)
        k, share = np.repeat(np.arange(len(dt)), count), np.tile(_SHARES, len(dt))
        times = self._plan.time[k] + share * dt[k]
        rate = self._rates(times, k, share, guess.at(k, share)[0])
        shape = len(dt), count, 3
        rate = rate.reshape(shape)
        turn, slope = guess.vector.at(k, share).reshape(shape), np.empty(shape)
        for _ in range(_ITERATIONS):
            slope = slope_of(turn, rate)
            turn = dt[:, None, None] * np.einsum("ij,kjx->kix", _INTEGRALS, slope)
        rising = dt[:, None, None] * np.einsum("ij,kjx->kix", _COEFFICIENTS, slope)
        by_momentum = np.concatenate([0 * turn[:, :1], rising / _ORDERS[:, None]], axis=1)
        # What is missing to the next knot, by a rate without steps, and at rest at both ends.
        needed = turns(quat)
        missing = needed - turn[:, -1]
        summed = np.vstack([np.zeros(3), np.cumsum(missing, axis=0)])
        added = CubicSpline(self._plan.time, summed, bc_type="clamped")(self._plan.time, 1)
        last = slope_of(needed, rate[:, -1] + added[1:]) - slope[:, -1]
        rest = Polynomials.between(missing, added[:-1], last, dt)
        return Turns(quat[:-1], Polynomials(by_momentum, dt) + rest)

    def _rates(self, times: Array, k: IntArray, share: Array, quat: Array) -> Array:
        """(K, 3) rad/s, base axes, with which the whole body has the planned momentum."""
        motion, feet = self._planned(times, k, share), self._feet(k, share)
        joints = self._postures(motion, quat, feet)[0]
        maps = momentum_maps(self._robot, joints)
        legs = self._robot.chains.motion(joints[:, self._robot.leg_joint_index], joints=joints)
        R_base_world = np.swapaxes(rotation_matrices(quat), -1, -2)

        def momentum(rate: Array) -> Array:
            rates = np.broadcast_to(rate, (len(times), 3))
            speeds = self._joint_speeds(joints, quat, rates, motion, feet, legs)
            return apply(maps, np.hstack([rates, speeds]))

        still = momentum(np.zeros(3))
        inertia = np.stack([momentum(axis) - still for axis in np.eye(3)], axis=-1)
        wanted = apply(R_base_world, motion["angular_momentum"]) - still
        inverse: Array = np.asarray(np.linalg.inv(inertia), dtype=np.float64)
        return apply(inverse, wanted)

    def _planned(self, times: Array, k: IntArray, share: Array) -> dict[str, Array]:
        planned = sampled(self._plan, times, ("com", "com_velocity", "angular_momentum"))
        arms = {"arms": self._arms.at(k, share), "arm_speed": self._arms.slopes(k, share)}
        return planned | arms

    def _feet(self, k: IntArray, share: Array) -> _Feet:
        rests = self._standing[k][..., None]
        place = np.where(rests, self._plan.foot_position[k], self._places.at(k, share))
        velocity = np.where(rests, 0.0, self._places.slopes(k, share))
        quat = self._plan.foot_quat[k]
        if self._soles is None:
            return _Feet(place, quat, velocity, None)
        flying, rate = self._soles.at(k, share)
        quat = np.where(rests, self._soles.start[k], flying)
        omega = np.where(rests, 0.0, apply(rotation_matrices(quat), rate))
        return _Feet(place, quat, velocity, omega)

    def _postures(self, motion: dict[str, Array], quat: Array, feet: _Feet) -> tuple[Array, Array]:
        """Joints (K, J), and the base's origin (K, 3)."""
        time = self._plan.time
        near = interpolated(motion["time"], time, self._joints)
        near[:, self._robot.arm_joint_index] = motion["arms"]
        found = solve_postures(self._robot, motion["com"], quat, feet.place, feet.quat, near=near)
        return found.joint_position, found.base_position

    def _joint_speeds(
        self,
        joints: Array,
        quat: Array,
        rate: Array,
        motion: dict[str, Array],
        feet: _Feet,
        legs: LegMotion | None = None,
    ) -> Array:
        """(K, J) per s, with the base's rate (K, 3) rad/s in its axes."""
        omega = apply(rotation_matrices(quat), rate)
        velocities = motion["com_velocity"], feet.velocity, feet.omega
        speed = motion["arm_speed"]
        return joint_speeds(self._robot, joints, quat, omega, *velocities, legs, speed)

    def at(self, instants: Interpolation) -> dict[str, Array]:
        k, share = instants.left, instants.share
        moving = ~instants.outside[:, None]
        motion, feet = self._planned(instants.time, k, share), self._feet(k, share)
        quat, rate = self._base.at(k, share)
        joints, base = self._postures(motion, quat, feet)
        speeds = self._joint_speeds(joints, quat, rate, motion, feet)
        return {
            "base_quat": quat,
            "base_position": base,
            "angular_velocity": apply(rotation_matrices(quat), rate) * moving,
            "foot_position": feet.place,
            "foot_quat": feet.quat,
            "contact_point": self._contact_points(feet),
            "joint_position": joints,
            "joint_velocity": speeds * moving,
        }

    def _contact_points(self, feet: _Feet) -> Array:
        """(K, C, 3) m, fixed to the feet."""
        corners = rotation_matrices(feet.quat) @ self._robot.corners.T
        points = feet.place[:, :, None] + np.swapaxes(corners, -1, -2)
        return points.reshape(len(points), -1, 3)
