"""A log of joints that move in the air, as one object, whatever file it is read from.

CSV: a row a command, with columns `time` (s) and of each joint `q:NAME` (rad), `dq:NAME` (rad/s)
and `tau:NAME` (Nm, as commanded, held until the next row); with the base's inertial unit also
`gyro:x|y|z` (rad/s) and `acceleration:x|y|z` (m/s2, +9.81 along z at rest), base frame.
MCAP: the player's own log, all of an excitation; of a played plan only its free fall enters.
"""

import io
import json
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from llsrbm.arrays import Array, BoolArray
from llsrbm.errors import FileFormatError, InputError, printable, require
from llsrbm.mechanics import GRAVITY
from llsrbm.player.play_log import STATES
from llsrbm.request.messages import choices
from llsrbm.robots import Robot
from llsrbm.text_files import read_text

EXCITATION = "excitation"  # the tier whose logs are of a robot that hangs

_LARGEST = 2_000_000_000  # bytes: 10 min of 40 joints at 1 kHz
_LEAST = 2.0  # s
_SLOWEST = 0.01  # s between rows: rotors show in what is faster than slow swings
_GAP = 3.0  # periods without a row, within which joints may do anything
_FREE_FALL = 0.3 * GRAVITY  # m/s2 that an inertial unit shows in flight, at most
_AXES = "xyz"
_EXPECTED = "expected a log of `llsrbm deploy`"
_TOPICS = ("/play", "/command", "/readings")


@dataclass(frozen=True, eq=False)
class Log:
    """K rows, evenly spaced, of J joints in `Robot.joint_names`' order.

    Attributes:
        name: the file's, without its folder; period: s between rows.
        q, dq: (K, J) rad, rad/s as measured.
        sent: (K, J) Nm, what of the commanded torque comes with each command, held until the next.
        feedback: (K, J) Nm, what motors take off it by gains of their own, at once.
        gyro, acceleration: (K, 3) rad/s, m/s2, the base's inertial unit; None: held and level.
        usable: (K,) whether a row is of joints in the air, and rows around it are there.
    """

    name: str
    period: float
    q: Array
    dq: Array
    sent: Array
    feedback: Array
    usable: BoolArray
    gyro: Array | None = None
    acceleration: Array | None = None


def read_log(path: Path, robot: Robot) -> Log:
    """Read a log of a robot. Raises `InputError`: one line."""
    if path.suffix == ".csv":
        return _read_csv(path, robot)
    if path.suffix == ".mcap":
        return _read_mcap(path, robot)
    raise InputError(f"{path}: expected a log that ends in .csv or .mcap")


def _read_csv(path: Path, robot: Robot) -> Log:
    text = read_text(path, "a log in CSV", _LARGEST)
    header, _, rows = text.partition("\n")
    names = [name.strip() for name in header.split(",")]
    wanted = [
        "time",
        *(f"{of}:{joint}" for of in ("q", "dq", "tau") for joint in robot.joint_names),
    ]
    missing = [name for name in wanted if name not in names]
    for name in names:
        kind, _, joint = name.partition(":")
        if kind in ("q", "dq", "tau") and joint not in robot.joint_names:
            raise FileFormatError(
                f"{path}: column {printable(name)}: {robot.name} has no such joint; "
                f"{choices(joint, robot.joint_names)}"
            )
    if missing or len(set(names)) < len(names):
        more = f" and {len(missing) - 1} more" if len(missing) > 1 else ""
        fault = f"no column {missing[0]}{more}" if missing else "a column is there twice"
        raise FileFormatError(
            f"{path}: {fault}; expected time, and q:NAME, dq:NAME, tau:NAME of every joint"
        )
    inertial = [f"{of}:{axis}" for of in ("gyro", "acceleration") for axis in _AXES]
    hangs_free = all(name in names for name in inertial)
    wanted += inertial if hangs_free else []
    try:
        table = np.loadtxt(
            io.StringIO(rows),
            delimiter=",",
            usecols=[names.index(name) for name in wanted],
            ndmin=2,
        )
    except ValueError as reason:
        raise FileFormatError(
            f"{path}: {printable(str(reason), 200)}; expected numbers"
        ) from reason
    if not np.isfinite(table).all():
        row, column = np.argwhere(~np.isfinite(table))[0]
        raise FileFormatError(
            f"{path}: row {row + 1}: {wanted[column]} is not finite; expected finite numbers"
        )
    q, dq, tau, *base = np.split(table[:, 1:], np.cumsum([len(robot.joint_names)] * 3), axis=1)
    return _evenly(
        path,
        table[:, 0],
        tau,
        {
            "q": q,
            "dq": dq,
            "feedback": np.zeros_like(tau),
            "gyro": base[0][:, :3],
            "acceleration": base[0][:, 3:],
        },
        np.ones(len(table), dtype=bool),
    )


def _read_mcap(path: Path, robot: Robot) -> Log:
    require("logs in MCAP need its reader", "mcap", "mcap")
    about, rows = _messages(path)
    of_tick = [row for row in rows if row.keys() >= set(_TOPICS)]
    if not of_tick:
        raise FileFormatError(f"{path}: no commands with readings; {_EXPECTED}")
    joints = robot.joint_names
    if set(of_tick[0]["/readings"].get("q", ())) != set(joints):
        raise FileFormatError(f"{path}: expected a log of {robot.name}, got another robot's joints")

    def columns(topic: str, name: str, parts: Sequence[str]) -> Array:
        try:
            return np.array([[row[topic][name][part] for part in parts] for row in of_tick])
        except (KeyError, TypeError) as reason:
            raise FileFormatError(f"{path}: {topic} without {name}; {_EXPECTED}") from reason

    q, dq = (columns("/readings", name, joints) for name in ("q", "dq"))
    command = {name: columns("/command", name, joints) for name in ("q", "dq", "tau", "kp", "kd")}
    gyro, acceleration = (columns("/readings", name, _AXES) for name in ("gyro", "acceleration"))
    playing = columns("/play", "state", ["number"])[:, 0] == STATES.index("jump")
    if about.get("tier") != EXCITATION:  # feet stand
        playing &= np.linalg.norm(acceleration, axis=1) < _FREE_FALL
    kp, kd = command["kp"], command["kd"]
    measured = {"q": q, "dq": dq, "feedback": kp * q + kd * dq}
    return _evenly(
        path,
        columns("/play", "robot_time", ["time"])[:, 0],
        command["tau"] + kp * command["q"] + kd * command["dq"],
        {**measured, "gyro": gyro, "acceleration": acceleration},
        playing,
    )


def _messages(path: Path) -> tuple[dict[str, str], list[dict[str, Any]]]:
    """The record "llsrbm", and the messages of each instant, topic -> content."""
    from mcap.exceptions import McapError
    from mcap.reader import make_reader

    rows: dict[int, dict[str, Any]] = {}
    try:
        with path.open("rb") as file:
            reader = make_reader(file)
            about = next((m.metadata for m in reader.iter_metadata() if m.name == "llsrbm"), {})
            for _, channel, message in reader.iter_messages(topics=_TOPICS):
                content = json.loads(message.data)
                rows.setdefault(message.log_time, {})[channel.topic] = content
    except (OSError, McapError, ValueError, EOFError, struct.error) as reason:
        raise FileFormatError(
            f"{path}: cannot be read ({printable(str(reason))}); {_EXPECTED}"
        ) from reason
    return about, [rows[time] for time in sorted(rows)]


def _evenly(
    path: Path,
    time: Array,
    sent: Array,
    measured: dict[str, Array],
    usable: BoolArray,
) -> Log:
    """The log with rows evenly spaced: what is measured between rows, what is held as it was."""
    late = np.flatnonzero(np.diff(time) <= 0)
    if len(late):
        row = int(late[0]) + 2
        raise FileFormatError(
            f"{path}: row {row}: time {time[row - 1]:g} after {time[row - 2]:g}; expected "
            "increasing times"
        )
    if len(time) < 2 or time[-1] - time[0] < _LEAST:
        raise FileFormatError(f"{path}: expected a log of {_LEAST:g} s or more")
    period = float(np.median(np.diff(time)))
    if period > _SLOWEST:
        raise FileFormatError(
            f"{path}: a row each {1e3 * period:.3g} ms; expected one each {1e3 * _SLOWEST:g} ms or "
            "less, as commands were sent"
        )
    period = (time[-1] - time[0]) / round((time[-1] - time[0]) / period)
    even = np.arange(time[0], time[-1] + period / 2, period)
    before = np.clip(np.searchsorted(time, even + period / 2) - 1, 0, len(time) - 1)
    after = np.minimum(before + 1, len(time) - 1)
    there = usable[before] & usable[after] & (time[after] - time[before] < _GAP * period)
    columns = {
        name: np.column_stack([np.interp(even, time, each) for each in values.T])
        for name, values in measured.items()
        if values.shape[1]
    }
    return Log(path.name, period, sent=sent[before], usable=there, **columns)
