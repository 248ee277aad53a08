"""Motor commands for Unitree's LowCmd, as a table: 500 rows/s, five numbers a motor.

A header; then `time` s from 0 on, and for every motor that the robot has, by its number n in the
message, `q_n` rad, `dq_n` rad/s, `tau_n` Nm, `kp_n` Nm/rad, `kd_n` Nm s/rad. Motors apply
tau + kp (q - q measured) + kd (dq - dq measured). Go2, Go1 and A1: 0-11, FR, FL, RR, RL x hip,
thigh, calf; G1: 0-28, left leg, right leg, waist, left arm, right arm, with ankles as pitch and
roll (mode_pr 0). Joints that the robot's file holds, G1's waist and wrists, stay at the held angle
by the file's gains. Numbers of the message beyond those of the table are to be left idle.

A row holds until the next. Positions and speeds are the motion's at the row's instant. Torques of a
plan are those of inverse dynamics over the interval between knots in which the instant lies, of a
refined plan straight lines through them; those of a rollout are what was applied, feedback
included. They jump where feet leave the ground or meet it: a row on such an edge has the torque of
the phase that begins, so an edge is late by less than a row.

The gains are `kp` and `kd` of [wire] in the robot's file: for motors that follow the table alone,
without a controller. The JSON file beside it has `motors` (number, joint), `family`, request, robot
and certificate.

Option `packed`: under the name with ".messages" added, one message a row, as the SDK's C structure
lies in memory, little endian, checksum included: 812 bytes each of Go2, 1,004 of G1. Motors that
are not there are idle in it. A G1 takes only commands with the `mode_machine` of its own LowState;
here it is 0, so a player has to put it in and make the checksum anew.

Nobody here has run it on a robot.
"""

from pathlib import Path

import numpy as np

from llsrbm.errors import InputError
from llsrbm.formats.base import Format, Options, Purpose
from llsrbm.formats.wire.numbers import interleaved, write_numbers
from llsrbm.motion.trajectory import Trajectory
from llsrbm.robots import Robot
from llsrbm.wire.command_table import CommandTable, command_table
from llsrbm.wire.motor_map import MotorMap
from llsrbm.wire.unitree import UnitreeMessages
from llsrbm.wire.unitree_layouts import FAMILIES

_MESSAGES = ".messages"  # after the whole name of the table
_PARTS = ("q", "dq", "tau", "kp", "kd")  # in the message's order
_UNITS = ("rad", "rad/s", "Nm", "Nm/rad", "Nm s/rad")


def _write(trajectory: Trajectory, path: Path, options: Options) -> None:
    table = command_table(trajectory, options.fps, options.pad)
    motors = table.motors
    columns = (
        motors.positions(table.q),
        motors.speeds(table.dq),
        motors.torques(table.tau),
        motors.stiffness(table.kp),
        motors.damping(table.kd),
    )
    numbers = np.flatnonzero(motors.used)
    rows = np.column_stack([table.time, interleaved(*(each[:, numbers] for each in columns))])
    header = ["time", *(f"{part}_{number}" for number in numbers for part in _PARTS)]
    write_numbers(path, header, rows)
    if options.packed:
        _write_messages(table, path.with_name(path.name + _MESSAGES))
    LOWCMD.write_beside(
        path,
        trajectory,
        options,
        family=motors.family,
        motors=[{"number": int(n), "joint": motors.joints[n]} for n in numbers],
        columns=header,
        column_units=["s", *_UNITS * len(numbers)],
    )


def _fits(robot: Robot) -> None:
    family = MotorMap.of(robot).family
    if family not in FAMILIES:
        raise InputError(
            f"robot {robot.name} has messages of family {family} and no LowCmd; expected "
            f"{' or '.join(FAMILIES)}"
        )


def _write_messages(table: CommandTable, path: Path) -> None:
    messages = UnitreeMessages(table.robot)
    packed = (messages.pack_command(table.row(k)).tobytes() for k in range(len(table.time)))
    path.write_bytes(b"".join(packed))


LOWCMD = Format(
    name="lowcmd",
    title="motor commands for Unitree's LowCmd: 500 rows/s of q, dq, tau, kp, kd by motor",
    purpose=Purpose.ROBOT,
    suffix=".csv",
    write=_write,
    fits=_fits,
    conventions=__doc__,
    options=("fps", "pad", "packed"),
    defaults=Options(fps=500.0),
)
