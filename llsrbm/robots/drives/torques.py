"""A robot's drives: the torque that they can give at a speed, and what of it friction takes.

A drive's torque moves its rotor and its joint, against the drive's own friction:

    tau = (M a + h - J^T f)_joint + I q'' + F tanh(q' / w) + D q',

with the rotor's inertia I as the joint feels it (`Robot.armature`; Pinocchio's mass matrix and
inverse dynamics have it), Coulomb friction F, smooth about zero speed, and damping D.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from llsrbm.arrays import Array
from llsrbm.robots.robot import Robot

FULL_UP_TO = 0.7
"""Share of the speed limit up to which the whole torque is there; from there it falls to zero."""

STILL = 0.01
"""w as a share of the joint's speed limit: friction turns about within some 0.3 rad/s of rest."""

_SLOWEST = 1e-6  # rad/s or m/s: no drive takes back anything at rest
_ZERO = np.zeros(())  # an array: a float takes NumPy longer to look at than to compare


def torque_range(robot: Robot, speed: Array) -> tuple[Array, Array]:
    """Lowest and highest torque, (..., J) each, Nm or N, at speeds (..., J) rad/s or m/s.

    Driving torque falls in a straight line to zero at the speed limit; braking torque falls where
    the drive would take back more than its file's `limits.regeneration`. Joints are in the order of
    `Robot.joint_names`.
    """
    torque, at_rest, slope = _lines(robot)
    drop, power = slope * speed, robot.file.limits.regeneration
    # Minimum and maximum take a third of clip's time.
    lowest = np.maximum(np.minimum(-at_rest - drop, _ZERO), -torque)
    highest = np.minimum(np.maximum(at_rest - drop, _ZERO), torque)
    if power is None:
        return lowest, highest
    braking = _braking(power, speed)
    return (
        np.where(speed > 0, np.maximum(lowest, -braking), lowest),
        np.where(speed < 0, np.minimum(highest, braking), highest),
    )


def torque_in_direction(robot: Robot, speed: Array, torque: Array) -> Array:
    """Largest torque (..., J) Nm or N at a speed in the direction, the sign, of `torque` (..., J).

    Called in every step of a simulation.
    """
    limit, at_rest, slope = _lines(robot)
    along = np.copysign(1.0, torque) * speed  # negative: it brakes
    most: Array = np.minimum(np.maximum(at_rest - slope * along, _ZERO), limit)
    power = robot.file.limits.regeneration
    if power is None:
        return most
    return np.where(along < 0, np.minimum(most, _braking(power, speed)), most)


def friction_torque(robot: Robot, speed: Array) -> Array:
    """Torque (..., J), Nm or N, that friction and damping take at speeds (..., J)."""
    friction, damping, per_width = _losses(robot)
    return friction * np.tanh(per_width * speed) + damping * speed


def _braking(power: float, speed: Array) -> Array:
    """Torque (..., J) that brakes at speeds (..., J) with a power, W."""
    return power / np.maximum(np.abs(speed), _SLOWEST)


@lru_cache(maxsize=16)
def _losses(robot: Robot) -> tuple[Array, Array, Array]:
    """(J,) each: Coulomb friction, damping, and 1 / w."""
    return robot.friction, robot.damping, 1.0 / (STILL * robot.rated_speed)


@lru_cache(maxsize=16)
def _lines(robot: Robot) -> tuple[Array, Array, Array]:
    """(J,) each: the torque at low speeds, and where that ends the line `at_rest - slope speed`.

    The line is at the whole torque at `FULL_UP_TO` of the speed limit and at zero at the limit.
    """
    torque, share = robot.torque_limit, 1.0 - FULL_UP_TO
    return torque, torque / share, torque / (share * robot.speed_limit)
