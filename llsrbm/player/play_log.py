"""`PlayLog`: everything that a player has read and sent, tick by tick."""

import numpy as np

from llsrbm.arrays import Array
from llsrbm.control.motor_command import MotorCommand
from llsrbm.control.readings import Readings
from llsrbm.robots import Robot

STATES = ("check", "ramp", "stand", "jump", "damp")
_COMMAND = ("q", "dq", "tau", "kp", "kd")
_READINGS = ("quat", "gyro", "acceleration", "q", "dq", "torque", "foot_force")


_Row = tuple[str, float, float, Readings, MotorCommand | None, tuple[Array, Array] | None]


class PlayLog:
    """Rows in memory, so that no disk delays a command; T of them, J joints.

    `arrays` has columns: `time` (T,) s by the player's clock, `state` (T,) into `STATES`,
    `computing` (T,) s from a reading to its command, `robot_time` (T,) s, `command/q`, `/dq`,
    `/tau`, `/kp`, `/kd` (T, J), NaN where nothing was sent, `readings/...` as in `Readings`, and
    `estimate/q` (T, nq), `estimate/v` (T, nv), Pinocchio's, NaN without an estimate.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self._rows: list[_Row] = []

    def __len__(self) -> int:
        return len(self._rows)

    def add(
        self,
        state: str,
        time: float,
        computing: float,
        readings: Readings,
        command: MotorCommand | None,
        estimate: tuple[Array, Array] | None,
    ) -> None:
        """Take one tick: state, when its reading came, how long it took, what was read and sent."""
        self._rows.append((state, time, computing, readings, command, estimate))

    def arrays(self) -> dict[str, Array]:
        """The columns, see the class."""
        states, times, computing, readings, commands, estimates = (
            list(column) for column in zip(*self._rows, strict=True)
        )
        columns = {
            "time": np.array(times),
            "state": np.array([STATES.index(state) for state in states], dtype=float),
            "computing": np.array(computing),
            "robot_time": np.array([each.time for each in readings]),
        }
        model = self.robot.model
        silent = np.full(model.nv - 6, np.nan)
        for name in _COMMAND:
            values = [silent if each is None else getattr(each, name) for each in commands]
            columns[f"command/{name}"] = np.array(values)
        for name in _READINGS:
            read = [getattr(each, name) for each in readings]
            if read[0] is not None:
                columns[f"readings/{name}"] = np.array(read)
        unknown = np.full(model.nq, np.nan), np.full(model.nv, np.nan)
        for k, name in enumerate("qv"):
            values = [(unknown if each is None else each)[k] for each in estimates]
            columns[f"estimate/{name}"] = np.array(values)
        return columns
