"""Logs whose columns have other units, signs or zeros than they should: told before drives are."""

import numpy as np

from llsrbm.arrays import Array
from llsrbm.errors import InputError
from llsrbm.identification.log import Log
from llsrbm.robots import Robot

_BEYOND = 0.3  # rad or m beyond a stop in half of the rows; encoders' zeros are off by less
_WINDOW = 0.02  # s over which speeds are compared: noise of positions is little against it
_LEAST_SPEED = 0.05  # rad/s or m/s RMS; of slower joints the ratio is noise
_RATIO = 2.0  # of speeds to the change of positions, either way: filters take less


def check_units(robot: Robot, log: Log) -> None:
    """Raise `InputError` if positions, speeds or torques of a log cannot be in SI units."""
    _check_positions(robot, log)
    _check_torques(robot, log)
    _check_speeds(robot, log)


def _check_positions(robot: Robot, log: Log) -> None:
    lower, upper = robot.joint_stops
    usual = np.median(log.q[log.usable], axis=0)
    beyond = np.maximum(lower - usual, usual - upper)
    joint = int(beyond.argmax())
    if beyond[joint] > _BEYOND:
        name = robot.joint_names[joint]
        raise InputError(
            f"{log.name}: q:{name} is at {usual[joint]:.3g} in most rows, beyond its stops "
            f"({lower[joint]:.3g} to {upper[joint]:.3g}); expected {_unit(robot, name)}, with the "
            "zero and the direction of the URDF"
        )


def _check_torques(robot: Robot, log: Log) -> None:
    usual = np.median(np.abs(log.sent - log.feedback)[log.usable], axis=0)
    joint = int((usual / robot.torque_limit).argmax())
    if usual[joint] > robot.torque_limit[joint]:
        name = robot.joint_names[joint]
        raise InputError(
            f"{log.name}: tau:{name} is {usual[joint]:.3g} in most rows, and its drive gives "
            f"{robot.torque_limit[joint]:.3g} at most; expected "
            f"{'N' if name in robot.sliding_joints else 'Nm'}"
        )


def _check_speeds(robot: Robot, log: Log) -> None:
    rows = max(1, round(_WINDOW / log.period))
    there = log.usable[rows:] & log.usable[:-rows]
    change = ((log.q[rows:] - log.q[:-rows]) / (rows * log.period))[there]
    speed = _moving_mean((log.dq[1:] + log.dq[:-1]) / 2, rows)[there]
    squares = np.sum(change**2, axis=0)
    moves = squares > len(change) * _LEAST_SPEED**2
    ratio = np.where(moves, np.sum(speed * change, axis=0), 1.0) / np.where(moves, squares, 1.0)
    off = np.abs(np.log(np.maximum(ratio, 1e-6)))
    joint = int(off.argmax())
    if off[joint] > np.log(_RATIO):
        name = robot.joint_names[joint]
        raise InputError(
            f"{log.name}: dq:{name} is {ratio[joint]:.3g} times the change of q:{name} with time; "
            f"expected {_unit(robot, name)}/s"
        )


def _moving_mean(values: Array, rows: int) -> Array:
    total = np.vstack([np.zeros_like(values[:1]), np.cumsum(values, axis=0)])
    return (total[rows:] - total[:-rows]) / rows


def _unit(robot: Robot, joint: str) -> str:
    return "m" if joint in robot.sliding_joints else "rad"
