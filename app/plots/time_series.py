"""Quantities of one motion over time, planned, simulated or from a file, under the same names."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np

from llsrbm.analysis.inertia_ellipsoid import ellipsoid
from llsrbm.arrays import Array
from llsrbm.body.momentum import centroidal_states
from llsrbm.mechanics import rotation_matrices
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.sampling import resample
from llsrbm.motion.whole_body import WholeBodyMotion, motion_at_ticks
from llsrbm.robots import Robot

_WHOLE_BODY_EVERY = 3  # frames; an inertia changes slowly, and each costs some 15 microseconds
_COMMON = frozenset(field.name for field in fields(WholeBodyMotion))
_RECORDED_AS = {"joint_torque": "torque", "joint_torque_limit": "torque_limit"}  # in a `Rollout`


@dataclass(frozen=True, eq=False)
class TimeSeries:
    """A motion's quantities at its K own instants; world frame, SI units."""

    motion: WholeBodyMotion  # the quantities that plans, simulations and files have in common
    # all others: a plan or a rollout; None of a motion from another tool
    recorded: Plan | Rollout | None
    planned: WholeBodyMotion | None  # the plan that a simulation followed; None of all else
    mass: float  # of which the momenta are, kg

    @classmethod
    def of_plan(cls, plan: Plan, motion: WholeBodyMotion) -> TimeSeries:
        """A plan's quantities at the instants of `motion`, which was made from it."""
        return cls(motion, plan, None, motion.robot.mass)

    @classmethod
    def of_motion(cls, motion: WholeBodyMotion) -> TimeSeries:
        """Those of a motion from a file."""
        return cls(motion, None, None, motion.robot.mass)

    @classmethod
    def of_rollout(cls, rollout: Rollout, planned: WholeBodyMotion | None) -> TimeSeries:
        """Those of a simulation at every control tick; `planned` is the motion that it followed."""
        motion = motion_at_ticks(rollout, np.arange(len(rollout.time)))
        # Momenta are those of the simulated masses.
        return cls(motion, rollout, planned, rollout.disturbance.mass(motion.robot))

    @property
    def robot(self) -> Robot:
        """The robot that moves."""
        return self.motion.robot

    @property
    def time(self) -> Array:
        """(K,) s, increasing."""
        return self.motion.time

    @property
    def rollout(self) -> Rollout | None:
        """The simulation, if it is one."""
        return self.recorded if isinstance(self.recorded, Rollout) else None

    @cached_property
    def com_velocity(self) -> Array:
        """(K, 3) m/s, by the linear momentum."""
        return self.motion.linear_momentum / self.mass

    @cached_property
    def average_spatial_velocity_norm(self) -> Array:
        """(K,) m/s and rad/s in one norm; of a simulation, as measured by its controller."""
        if self.rollout is not None:
            return self.rollout.average_spatial_velocity_norm
        momentum = self.motion.angular_momentum[..., None]
        turning = np.linalg.solve(self.motion.inertia, momentum)[..., 0]
        return np.linalg.norm(np.hstack([self.com_velocity, turning]), axis=1)

    def quantity(self, name: str) -> Array | None:
        """(K, ...) of a quantity by its name in `Plan`, joints in the robot's order; None: none."""
        if name in ("com_velocity", "average_spatial_velocity_norm"):
            found: Any = getattr(self, name)
        elif name in _COMMON:
            found = getattr(self.motion, name)
        else:
            found = getattr(self._sampled, name, None)
        return None if found is None else np.asarray(found, dtype=np.float64)

    @cached_property
    def _sampled(self) -> Plan | Rollout | None:
        if isinstance(self.recorded, Plan):
            return resample(self.recorded, self.recorded.time[0] + self.time)
        return self.recorded


def recorded_name(name: str) -> str:
    """Name of a rollout's quantity in `TimeSeries.quantity`."""
    return {recorded: ours for ours, recorded in _RECORDED_AS.items()}.get(name, name)


def principal_moments(robot: Robot, inertia: Array, base_quat: Array) -> Array:
    """Principal moments, (K, 3) kg m2, nearest to the base's axes, of `inertia` (K, 3, 3) kg m2."""
    axes, _ = ellipsoid(inertia, robot.mass, rotation_matrices(base_quat))
    squares: Array = axes**2
    return robot.mass / 5 * (squares.sum(axis=1, keepdims=True) - squares)


def whole_body_inertia(motion: WholeBodyMotion) -> tuple[Array, Array, Array]:
    """By the whole-body model: time (K,) s, inertia (K, 3, 3) kg m2, base_quat (K, 4)."""
    robot = motion.robot
    kept = np.arange(0, len(motion.time), _WHOLE_BODY_EVERY)
    quat = motion.base_quat[kept]
    q = np.hstack([motion.base_position[kept], quat[:, [1, 2, 3, 0]], motion.joint_position[kept]])
    still = np.zeros((len(kept), robot.model.nv))
    return motion.time[kept], centroidal_states(robot.model, q, still)[1], quat
