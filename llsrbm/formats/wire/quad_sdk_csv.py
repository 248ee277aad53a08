"""Leg commands of quad-sdk (quad_msgs/LegCommandArray) as a table: 500 rows/s, its control rate.

A header; then `time` s from 0 on, and the numbers of each motor under their paths in the message,
`leg_commands[L].motor_commands[M].FIELD`. Legs 0-3 are FL, BL, FR, BR, motors 0-2 of a leg
abduction, hip, knee. Fields: `pos_setpoint` rad, `vel_setpoint` rad/s, `kp` Nm/rad, `kd` Nm s/rad,
`torque_ff` Nm. Fields that are diagnostics, and stamps, are left out: fill in `header.stamp` from
`time`.

Angles are those of the robot's URDF here, which are Unitree's: quad-sdk's interface to Unitree's
robots passes them on as they are. Its own models of other robots, Spirit's, have other zeros and
senses.

A row holds until the next. Torques of a plan are those of inverse dynamics over the interval
between knots, of a rollout what was applied; they jump at lift-off and touchdown, and a row on such
an edge has those of the phase that begins. The gains are `kp` and `kd` of [wire] in the robot's
file, for motors that follow the table alone. The JSON file beside it has the joints' names
(`joint_order`, leg after leg), request and robot. Nobody here has run it on a robot.
"""

from pathlib import Path

import numpy as np

from llsrbm.formats.base import Format, Options, Purpose
from llsrbm.formats.wire.numbers import interleaved, write_numbers
from llsrbm.formats.wire.quadruped import corner_legs
from llsrbm.motion.trajectory import Trajectory
from llsrbm.robots import Robot
from llsrbm.wire.command_table import command_table
from llsrbm.wire.motor_map import MotorMap

_LEGS = ("FL", "RL", "FR", "RR")  # 0 to 3; the rear ones are called BL and BR there
_UNITS = {
    "pos_setpoint": "rad",
    "vel_setpoint": "rad/s",
    "kp": "Nm/rad",
    "kd": "Nm s/rad",
    "torque_ff": "Nm",
}


def _write(trajectory: Trajectory, path: Path, options: Options) -> None:
    table = command_table(trajectory, options.fps, options.pad)
    corners = corner_legs(table.robot, QUAD_SDK_CSV.name)
    legs = [corners[name] for name in _LEGS]
    joints = [table.robot.joint_names.index(joint) for leg in legs for joint in leg.joints]
    fields = (table.q, table.dq, table.kp, table.kd, table.tau)
    rows = np.column_stack([table.time, interleaved(*(each[:, joints] for each in fields))])
    motors = [
        f"leg_commands[{leg}].motor_commands[{motor}]"
        for leg in range(len(legs))
        for motor in range(len(legs[leg].joints))
    ]
    header = ["time", *(f"{motor}.{field}" for motor in motors for field in _UNITS)]
    write_numbers(path, header, rows)
    QUAD_SDK_CSV.write_beside(
        path,
        trajectory,
        options,
        joint_order=[table.robot.joint_names[joint] for joint in joints],
        columns=header,
        column_units=["s", *list(_UNITS.values()) * len(motors)],
    )


def _fits(robot: Robot) -> None:
    corner_legs(robot, QUAD_SDK_CSV.name)
    MotorMap.of(robot)


QUAD_SDK_CSV = Format(
    name="quad-sdk-csv",
    title="leg commands of quad-sdk (LegCommandArray): 500 rows/s, FL, BL, FR, BR",
    purpose=Purpose.ROBOT,
    suffix=".csv",
    write=_write,
    fits=_fits,
    conventions=__doc__,
    options=("fps", "pad"),
    defaults=Options(fps=500.0),
)
