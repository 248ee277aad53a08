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
and certificate. Nobody here has run it on a robot.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from llsrbm.errors import InputError
from llsrbm.formats.base import Format, Options
from llsrbm.formats.wire.numbers import interleaved, write_numbers
from llsrbm.motion.trajectory import Trajectory
from llsrbm.wire.command_table import command_table

_FAMILIES = ("unitree_go", "unitree_hg")
_PARTS = ("q", "dq", "tau", "kp", "kd")  # in the message's order
_UNITS = ("rad", "rad/s", "Nm", "Nm/rad", "Nm s/rad")


def _write(trajectory: Trajectory, path: Path, options: Options) -> None:
    table = command_table(trajectory, options.fps, options.pad)
    motors = table.motors
    if motors.family not in _FAMILIES:
        raise InputError(
            f"robot {table.robot.name} has messages of family {motors.family} and no LowCmd; "
            f"expected {' or '.join(_FAMILIES)}"
        )
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
    LOWCMD.write_beside(
        path,
        trajectory,
        options,
        family=motors.family,
        motors=[{"number": int(n), "joint": motors.joints[n]} for n in numbers],
        columns=header,
        column_units=["s", *_UNITS * len(numbers)],
    )


LOWCMD = Format(
    name="lowcmd",
    title="motor commands for Unitree's LowCmd: 500 rows/s of q, dq, tau, kp, kd by motor",
    suffix=".csv",
    write=_write,
    conventions=__doc__,
    options=("fps", "pad"),
    defaults=Options(fps=500.0),
)
