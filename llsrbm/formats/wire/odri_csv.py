"""Joint commands for robots of the Open Dynamic Robot Initiative, such as Solo12: 1000 rows/s.

A header; then `time` s from 0 on and five blocks of J numbers, each as one call of
odri_control_interface takes it: `position/JOINT` rad (SetDesiredPositions), `velocity/JOINT` rad/s
(SetDesiredVelocities), `torque/JOINT` Nm (SetTorques), `kp/JOINT` Nm/rad (SetPositionGains),
`kd/JOINT` Nm s/rad (SetVelocityGains). All are of joints, not of motors: the interface itself
applies numbers, polarity, gear and torque constant of its configuration. Those that the robot's
file has stand in the JSON file beside it, joint by joint in the columns' order (`motor_numbers`,
`reverse_polarities`, `gear_ratios`, `motor_constants`, `max_currents`): they are one published
robot's, to be compared with the configuration of yours. Joints are in the order of the robot's
URDF: FL, FR, HL, HR x HAA, HFE, KFE.

The interface cuts currents off at `max_currents`; `largest_currents` A are what the torques of this
file need. 8 A of Solo12's motors are 1.8 Nm at the joint, less than the 2.7 Nm that plans count on.

A row holds until the next. Torques of a plan are those of inverse dynamics over the interval
between knots, of a rollout what was applied; they jump at lift-off and touchdown, and a row on such
an edge has those of the phase that begins. The gains are `kp` and `kd` of [wire] in the robot's
file, for motors that follow the table alone. Nobody here has run it on a robot.
"""

from pathlib import Path
from typing import Any

import numpy as np

from llsrbm.errors import InputError
from llsrbm.formats.base import Format, Options, Purpose
from llsrbm.formats.wire.numbers import write_numbers
from llsrbm.motion.trajectory import Trajectory
from llsrbm.robots import Robot
from llsrbm.wire.command_table import CommandTable, command_table
from llsrbm.wire.motor_map import MotorMap

_FAMILY = "odri"
_BLOCKS = {
    "position": "rad",
    "velocity": "rad/s",
    "torque": "Nm",
    "kp": "Nm/rad",
    "kd": "Nm s/rad",
}


def _write(trajectory: Trajectory, path: Path, options: Options) -> None:
    table = command_table(trajectory, options.fps, options.pad)
    joints = table.robot.joint_names
    header = ["time", *(f"{block}/{joint}" for block in _BLOCKS for joint in joints)]
    rows = np.column_stack([table.time, table.q, table.dq, table.tau, table.kp, table.kd])
    write_numbers(path, header, rows)
    ODRI_CSV.write_beside(
        path,
        trajectory,
        options,
        joint_order=list(joints),
        **_configuration(table),
        columns=header,
        column_units=["s", *(unit for unit in _BLOCKS.values() for _ in joints)],
    )


def _fits(robot: Robot) -> None:
    family = MotorMap.of(robot).family
    if family != _FAMILY:
        raise InputError(
            f"robot {robot.name} has messages of family {family}; expected {_FAMILY}, a robot of "
            "the Open Dynamic Robot Initiative"
        )


def _configuration(table: CommandTable) -> dict[str, Any]:
    """The motors' numbers under the names of odri_control_interface's configuration."""
    wire, motors = table.robot.file.wire, table.motors
    assert wire is not None  # the table could not be without it
    one = np.ones(len(table.robot.joint_names))
    ratios = 1 / motors.joint_speeds(motors.used.astype(np.float64))
    known: dict[str, Any] = {
        "motor_numbers": [motors.joints.index(joint) for joint in table.robot.joint_names],
        "reverse_polarities": (ratios < 0).tolist(),
        "gear_ratios": np.abs(ratios).tolist(),
    }
    if wire.torque_constant is not None:
        torques = np.abs(table.tau).max(axis=0) / np.abs(ratios)
        known["motor_constants"] = (wire.torque_constant * one).tolist()
        known["largest_currents"] = (torques / wire.torque_constant).tolist()
    if wire.max_current is not None:
        known["max_currents"] = (wire.max_current * one).tolist()
    return known


ODRI_CSV = Format(
    name="odri-csv",
    title="joint commands for ODRI's robots (Solo12): 1000 rows/s of positions to gains",
    purpose=Purpose.ROBOT,
    suffix=".csv",
    write=_write,
    fits=_fits,
    conventions=__doc__,
    options=("fps", "pad"),
    defaults=Options(fps=1000.0),
)
