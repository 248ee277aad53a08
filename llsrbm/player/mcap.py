"""The log of a play as MCAP, for Foxglove, PlotJuggler and others: numbers to plot.

Log time is ns since the first reading. Topics, JSON with schemas, a message a tick:
  /play       state (0 check, 1 ramp, 2 stand, 3 jump, 4 damp), ms from reading to command, s by the
              robot's clock
  /command    q, dq, tau, kp, kd of each joint, as sent
  /readings   inertial unit, joints, feet
  /estimate   base and joints as the closed loop believes them: quaternion w, x, y, z
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from foxglove import Context, open_mcap

from llsrbm.arrays import Array
from llsrbm.formats.logs.mcap_log import Entry, flat, numbers
from llsrbm.formats.logs.series import Series
from llsrbm.player.play_log import PlayLog

_XYZ, _WXYZ = ("x", "y", "z"), ("w", "x", "y", "z")
_COMMAND = {"q": "rad", "dq": "rad/s", "tau": "Nm", "kp": "Nm/rad", "kd": "Nm s/rad"}


def write(log: PlayLog, path: Path, about: dict[str, Any]) -> None:
    """Write a log of one tick or more; `about` becomes its metadata record "llsrbm"."""
    columns = log.arrays()
    times = columns["time"] - columns["time"][0]
    context = Context()  # of its own: nothing reaches a server of the caller's
    with open_mcap(path, context=context) as writer:
        writer.write_metadata("llsrbm", flat(about))
        entries: list[Entry] = []
        for topic, series in _topics(log, columns):
            known = np.all([np.isfinite(each.values).all(axis=1) for each in series], axis=0)
            there = [
                Series(each.name, each.unit, each.parts, each.values[known]) for each in series
            ]
            entries += numbers(context, topic, times[known], there)
        for time, channel, message in sorted(entries, key=lambda entry: entry[0]):
            channel.log(message, log_time=time)


def _topics(log: PlayLog, columns: dict[str, Array]) -> Iterator[tuple[str, list[Series]]]:
    robot = log.robot
    joints = robot.joint_names
    computing, robot_time = 1e3 * columns["computing"], columns["robot_time"]
    yield (
        "/play",
        [
            Series("state", "", ("number",), columns["state"][:, None]),
            Series("computing", "ms", ("time",), computing[:, None]),
            Series("robot_time", "s", ("time",), robot_time[:, None]),
        ],
    )
    yield (
        "/command",
        [Series(name, unit, joints, columns[f"command/{name}"]) for name, unit in _COMMAND.items()],
    )
    readings = [
        Series("quat", "", _WXYZ, columns["readings/quat"]),
        Series("gyro", "rad/s", _XYZ, columns["readings/gyro"]),
        Series("acceleration", "m/s2", _XYZ, columns["readings/acceleration"]),
        Series("q", "rad", joints, columns["readings/q"]),
        Series("dq", "rad/s", joints, columns["readings/dq"]),
        Series("torque", "Nm", joints, columns["readings/torque"]),
    ]
    if "readings/foot_force" in columns:
        legs = tuple(leg.name for leg in robot.legs)
        readings.append(Series("foot_force", "N", legs, columns["readings/foot_force"]))
    yield "/readings", readings
    q, v = columns["estimate/q"], columns["estimate/v"]
    if np.isfinite(q).any():
        yield (
            "/estimate",
            [
                Series("position", "m", _XYZ, q[:, :3]),
                Series("quat", "", _WXYZ, q[:, [6, 3, 4, 5]]),
                Series("velocity_in_base", "m/s", _XYZ, v[:, :3]),
                Series("angular_velocity_in_base", "rad/s", _XYZ, v[:, 3:6]),
            ],
        )
