"""Tasks of the whole-body controller: accelerations that it wants (the paper's section V).

J dv/dt + bias = feedforward + kp error + kd error_rate
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.arrays import Array
from llsrbm.control.reference import Target
from llsrbm.control.whole_body import WholeBody, solved
from llsrbm.mechanics import rotation_matrices, turned_to, turns_about_z

_NONE, _IDENTITY = np.zeros(3), np.eye(3)


class TaskMotion(NamedTuple):
    """Motion of m task coordinates x, for n velocities v of the robot."""

    jacobian: Array  # (m, n): the coordinates' rate is `jacobian @ v`
    bias: Array  # (m,) their acceleration at zero `dv/dt`
    error: Array  # (m,) wanted minus actual
    error_rate: Array  # (m,) wanted minus actual rate
    feedforward: Array  # (m,) wanted acceleration


class Task(ABC):
    """A wish for some accelerations: J dv/dt + bias = feedforward + kp error + kd error_rate.

    It is fulfilled as far as its weight says. `gains`: stiffness, 1/s2, and damping, 1/s.
    """

    rows: int
    moves: ClassVar[bool] = True  # False: the ground holds what it is about, whatever joints do

    def __init__(self, gains: tuple[float, float]) -> None:
        self._stiffness, self._damping = gains

    @abstractmethod
    def motion(self, body: WholeBody, target: Target) -> TaskMotion:
        """The task's coordinates as they are, and as they should be."""

    def write(self, body: WholeBody, target: Target, jacobian: Array, command: Array) -> None:
        """Fill `jacobian` (rows, n) and the accelerations wanted of dv/dt, `command` (rows,)."""
        m = self.motion(body, target)
        jacobian[:] = m.jacobian
        np.multiply(m.error_rate, self._damping, out=command)
        if self._stiffness:
            command += self._stiffness * m.error
        command += m.feedforward
        command -= m.bias


class CentreOfMass(Task):
    """Position of the CoM, m; its Jacobian is the linear part of the momentum matrix."""

    rows = 3

    def motion(self, body: WholeBody, target: Target) -> TaskMotion:
        return TaskMotion(
            body.momentum_matrix[:3] / body.mass,
            body.momentum_bias[:3] / body.mass,
            target.com - body.com,
            target.com_velocity - body.com_velocity,
            target.com_acceleration,
        )


class AngularMomentum(Task):
    """Average angular velocity I^-1 L, rad/s, a coordinate of first order; I is the whole body's.

    The reference is the plan's own angular momentum, which on jumps is far from zero. Divided by
    the inertia, the same weight means the same for all robots and axes.
    """

    rows = 3

    def __init__(self, decay: float) -> None:
        super().__init__((0.0, decay))

    def motion(self, body: WholeBody, target: Target) -> TaskMotion:
        per_inertia = solved(body.inertia, _IDENTITY)
        return TaskMotion(
            per_inertia.dot(body.momentum_matrix[3:]),
            per_inertia.dot(body.momentum_bias[3:]),
            _NONE,
            per_inertia.dot(target.angular_momentum - body.angular_momentum),
            per_inertia.dot(target.angular_momentum_rate),
        )


class BaseOrientation(Task):
    """Attitude of the base, rad: AngleAxis(R_wanted R^T), world axes."""

    rows = 3

    def motion(self, body: WholeBody, target: Target) -> TaskMotion:
        jacobian = np.zeros((3, body.velocities))
        # The base's own angular velocity, turned into the world; it turns with itself: no bias.
        jacobian[:, 3:6] = body.R_world_base
        return TaskMotion(
            jacobian,
            _NONE,
            pin.log3(target.R_world_base @ body.R_world_base.T),
            target.angular_velocity - body.angular_velocity,
            target.angular_acceleration,
        )


class FootOrientation(Task):
    """Attitude of a foot in the world, rad: as soles meet the ground, headed as planned."""

    rows = 3

    def __init__(self, foot: int, gains: tuple[float, float]) -> None:
        super().__init__(gains)
        self._foot = foot

    def motion(self, body: WholeBody, target: Target) -> TaskMotion:
        i = self._foot
        heading, rate, acceleration = target.foot_heading[i]
        return TaskMotion(
            body.foot_rotation_jacobian[i],
            body.foot_rotation_bias[i],
            pin.log3(
                rotation_matrices(turned_to(body.normals[i], 2))
                @ turns_about_z(heading)
                @ body.R_world_foot[i].T
            ),
            np.array([0.0, 0.0, rate]) - body.foot_angular_velocity[i],
            np.array([0.0, 0.0, acceleration]),
        )


class Posture(Task):
    """Positions of some joints, rad or m.

    Of all, with a small weight, it makes the quadratic program definite.
    """

    def __init__(self, joints: Sequence[int], velocities: int, gains: tuple[float, float]) -> None:
        super().__init__(gains)
        self.rows = len(joints)
        self._joints = _places(joints)
        self._jacobian = np.eye(velocities)[6:][self._joints]
        self._none = np.zeros(self.rows)

    def motion(self, body: WholeBody, target: Target) -> TaskMotion:
        i = self._joints
        return TaskMotion(
            self._jacobian,
            self._none,
            target.joint_position[i] - body.q[7:][i],
            target.joint_velocity[i] - body.v[6:][i],
            self._feedforward(target),
        )

    def _feedforward(self, target: Target) -> Array:
        return self._none


class Arms(Posture):
    """Positions of the arms' joints, which swing as planned."""

    def _feedforward(self, target: Target) -> Array:
        return target.joint_acceleration[self._joints]


class SwingFeet(Task):
    """Positions of some feet's lowest points relative to the CoM, m, world axes.

    Relative, because in flight the CoM falls freely: a foot held to a place in the world would stop
    reaching for the ground when the robot arrives late.
    """

    def __init__(self, feet: Sequence[int], gains: tuple[float, float]) -> None:
        super().__init__(gains)
        self._feet = _places(feet)
        self.rows = 3 * len(feet)

    def motion(self, body: WholeBody, target: Target) -> TaskMotion:
        i = self._feet
        error = target.foot_from_com[i] - (body.foot[i] - body.com)
        error_rate = target.foot_velocity_from_com[i] - (body.foot_velocity[i] - body.com_velocity)
        return TaskMotion(
            body.foot_jacobian[i].reshape(self.rows, -1),
            body.foot_bias[i].ravel(),
            error.ravel(),
            error_rate.ravel(),
            (target.foot_acceleration_from_com[i] + target.com_acceleration).ravel(),
        )


class SeekingFeet(Task):
    """Velocities of feet that look for the ground while others stand: down at `speed`, m/s."""

    def __init__(self, feet: Sequence[int], speed: float, damping: float) -> None:
        super().__init__((0.0, damping))
        self._downwards = np.array([0.0, 0.0, -speed])
        self._feet = _places(feet)
        self.rows = 3 * len(feet)
        self._none = np.zeros(self.rows)

    def motion(self, body: WholeBody, target: Target) -> TaskMotion:
        i = self._feet
        return TaskMotion(
            body.foot_jacobian[i].reshape(self.rows, -1),
            body.foot_bias[i].ravel(),
            self._none,
            (self._downwards - body.foot_velocity[i]).ravel(),
            self._none,
        )


class StandingFeet(Task):
    """The points of feet that touch the ground come to rest: a soft contact constraint.

    Some damping brings feet back that bounce, and soles to lie flat; much of it fights the impact.
    """

    moves = False

    def __init__(self, feet: Sequence[int], points: int, damping: float) -> None:
        super().__init__((0.0, damping))
        self._points = _places([foot * points + j for foot in feet for j in range(points)])
        self.rows = 3 * points * len(feet)
        self._none = np.zeros(self.rows)

    def motion(self, body: WholeBody, target: Target) -> TaskMotion:
        i = self._points
        return TaskMotion(
            body.contact_jacobian[i].reshape(self.rows, -1),
            body.contact_bias[i].ravel(),
            self._none,
            -body.contact_velocity[i].ravel(),
            self._none,
        )


def _places(indices: Sequence[int]) -> slice | NDArray[np.intp]:
    """An index of them: where they follow each other a slice, which copies nothing."""
    first, last = indices[0], indices[-1]
    if list(indices) == list(range(first, last + 1)):
        return slice(first, last + 1)
    return np.array(indices)
