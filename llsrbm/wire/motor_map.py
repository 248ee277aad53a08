"""`MotorMap`: from `Robot.joint_names` to the motors of a robot's own messages, and back."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from llsrbm.arrays import Array, BoolArray, IntArray
from llsrbm.errors import InputError, RobotFileError
from llsrbm.motion.bodies import JointOrder, urdf_joints
from llsrbm.request.messages import choices
from llsrbm.robots import Robot
from llsrbm.robots.wire_schema import MESSAGE_MOTORS, Wire

_Index = IntArray


@dataclass(frozen=True, eq=False)
class MotorMap:
    """Motors of one robot, of which a message holds M = `count`; J joints move.

    Conversions take values (..., J) of the joints in `Robot.joint_names`' order and give those
    (..., M) of the motors, or back. Motors of joints that the robot's file holds stay at the held
    angle, at rest, by the file's gains. Numbers without a motor get 0.

    Attributes:
        family: of the messages, "unitree_go", "unitree_hg" or "odri".
        joints: (M,) names of the joints by number of motor; "" without one.
        used: (M,) whether there is a motor.
        kp, kd: (J,) Nm/rad and Nm s/rad (N/m, N s/m) of the file, to follow a plan's table by.
    """

    family: str
    joints: tuple[str, ...]
    used: BoolArray
    kp: Array
    kd: Array
    _number: _Index  # (J,) of each joint's motor
    _ratio: Array  # (M,) sign * gear
    _zero: Array  # (M,) rad or m
    _held: Array  # (M,) rad or m of joints that the file holds
    _is_held: BoolArray  # (M,)
    _stiffness: Array  # (M,) of the file, at the joints
    _damping: Array  # likewise

    @classmethod
    def of(cls, robot: Robot) -> MotorMap:
        """The map that the robot's file states.

        Raises:
            InputError: the file has no [wire].
            RobotFileError: [wire] names a joint that the URDF lacks, or none for one that moves.
        """
        return _motor_map(robot)

    @property
    def count(self) -> int:
        """M: motors in a message, used or not."""
        return len(self.joints)

    # ---- to the motors

    def positions(self, q: Array) -> Array:
        """Rad or m (..., J) of the joints -> (..., M) of the motors."""
        return self._ratio * (self._spread(q, self._held) - self._zero)

    def speeds(self, dq: Array) -> Array:
        """Rad/s or m/s (..., J) -> (..., M)."""
        return self._ratio * self._spread(dq)

    def torques(self, tau: Array) -> Array:
        """Nm or N (..., J) -> (..., M)."""
        return self._spread(tau) / self._ratio

    def stiffness(self, kp: Array, hold: bool = True) -> Array:
        """Nm/rad (..., J) -> (..., M); held joints get the file's, or none without `hold`."""
        return self._spread(kp, self._stiffness * hold) / self._ratio**2

    def damping(self, kd: Array) -> Array:
        """Nm s/rad (..., J) -> (..., M); held joints get the file's."""
        return self._spread(kd, self._damping) / self._ratio**2

    def _spread(self, moved: Array, held: Array | float = 0.0) -> Array:
        moved = np.asarray(moved, dtype=np.float64)
        motors = np.zeros((*moved.shape[:-1], self.count))
        motors += np.where(self._is_held, held, 0.0)
        motors[..., self._number] = moved
        return motors

    # ---- from the motors

    def joint_positions(self, motors: Array) -> Array:
        """Rad or m (..., M) of the motors -> (..., J) of the joints."""
        return self._gathered(np.asarray(motors) / self._ratio + self._zero)

    def joint_speeds(self, motors: Array) -> Array:
        """Rad/s or m/s (..., M) -> (..., J)."""
        return self._gathered(np.asarray(motors) / self._ratio)

    def joint_torques(self, motors: Array) -> Array:
        """Nm or N (..., M) -> (..., J)."""
        return self._gathered(np.asarray(motors) * self._ratio)

    def joint_gains(self, motors: Array) -> Array:
        """Stiffness or damping (..., M) -> (..., J)."""
        return self._gathered(np.asarray(motors) * self._ratio**2)

    def _gathered(self, motors: Array) -> Array:
        return motors[..., self._number]


@lru_cache(maxsize=32)
def _motor_map(robot: Robot) -> MotorMap:
    wire = robot.file.wire
    if wire is None:
        raise InputError(
            f"{robot.path}: {robot.file.title} has no table [wire] of its motors; expected "
            "its message family and motors there, for anything that goes to the robot's own wire"
        )
    order = urdf_joints(robot)
    _check_names(robot, wire, order)
    spare = max(MESSAGE_MOTORS.get(wire.family, 0) - len(wire.motors), 0)
    joints = (*wire.motors, *[""] * spare)
    place = {joint: k for k, joint in enumerate(order.joints)}
    held = [bool(joint) and order.index[place[joint]] < 0 for joint in joints]
    at = [order.held[place[joint]] if joint else 0.0 for joint in joints]
    kp, kd = _each(wire.kp, wire, spare), _each(wire.kd, wire, spare)
    number = np.array([joints.index(joint) for joint in robot.joint_names])
    return MotorMap(
        family=wire.family,
        joints=joints,
        used=np.array([joint != "" for joint in joints]),
        kp=kp[number],
        kd=kd[number],
        _number=number,
        _ratio=_each(wire.sign, wire, spare, 1.0) * _each(wire.gear, wire, spare, 1.0),
        _zero=_each(wire.zero, wire, spare),
        _held=np.array(at),
        _is_held=np.array(held),
        _stiffness=kp,
        _damping=kd,
    )


def _check_names(robot: Robot, wire: Wire, order: JointOrder) -> None:
    for joint in filter(None, wire.motors):
        if joint not in order.joints:
            raise RobotFileError(
                f'{robot.path}: wire.motors: the URDF has no joint "{joint}"; '
                f"{choices(joint, order.joints)}"
            )
    missing = [joint for joint in robot.joint_names if joint not in wire.motors]
    if missing:
        raise RobotFileError(
            f"{robot.path}: wire.motors: no motor of {', '.join(missing)}; expected every joint "
            "that moves"
        )


def _each(
    value: float | tuple[float, ...] | None, wire: Wire, spare: int, otherwise: float = 0.0
) -> Array:
    """(M,): a number of each motor; `otherwise` where the file has none, and of spare numbers."""
    own = np.broadcast_to(otherwise if value is None else value, len(wire.motors))
    return np.concatenate([own, np.full(spare, otherwise)]).astype(np.float64)
