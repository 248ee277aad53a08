"""The drives' delay, known from measured torques, and the state that a command will meet."""

from collections import deque
from dataclasses import dataclass

import numpy as np

from llsrbm.arrays import Array
from llsrbm.control.inverse_dynamics import Command
from llsrbm.control.whole_body import WholeBody

MOST = 3  # ticks of delay that are looked for: 7.5 ms at 400 Hz, more than bus and drive take


@dataclass(frozen=True, eq=False)
class Measurement:
    """Everything that a controller knows of the world, at the beginning of a tick."""

    time: float  # s since the plan's start
    q: Array  # (nq,) and v: (nv,), estimated, Pinocchio's conventions
    v: Array
    torque: Array  # (J,) Nm or N, measured, mean of the tick that ended


class DelayEstimate:
    """Compares the torques that are measured with those that were sent, tick by tick.

    A torque that acts a tick too long at lift-off adds 2 % to a flip's angular momentum, which
    decides whether it lands. `known`: the drives' own delay, s; `ticks`: by how many more commands
    come late, as far as is known.
    """

    def __init__(self, tick: float, known: float = 0.0) -> None:
        self._tick = tick
        # In floating point 7.5 ms // 2.5 ms is 2.
        self._whole = int(late := round(known / tick, 6))
        self._part = late - self._whole
        # The last one first.
        self._sent: deque[Command] = deque(maxlen=MOST + self._whole + 2)
        self._misses = np.zeros(MOST + 1)  # by delay: what was measured less what was sent
        self.ticks = 0

    def sent(self, command: Command) -> None:
        """Take note of the command of a tick."""
        if not self._sent:
            self._torques = np.zeros((self._sent.maxlen or 0, len(command.torque)))
        self._sent.appendleft(command)
        self._torques[1:] = self._torques[:-1]
        self._torques[0] = command.torque

    def measured(self, torque: Array) -> None:
        """Take note of the torques (J,) of the tick that ended."""
        if len(self._sent) == self._sent.maxlen:
            sent = self._torques[self._whole :]
            come = (1 - self._part) * sent[:-1] + self._part * sent[1:]
            self._misses += np.abs(torque - come).sum(axis=1)
            self.ticks = int(self._misses.argmin())

    def acted(self) -> Array | None:
        """(n,) the accelerations that were expected of the tick that ended; None: unknown."""
        late = self._whole + self.ticks
        if len(self._sent) < late + 2:
            return None
        newer, older = self._sent[late].acceleration, self._sent[late + 1].acceleration
        return (1 - self._part) * newer + self._part * older

    def met(self, measurement: Measurement, body: WholeBody) -> Measurement:
        """The state in which the command of this tick will begin to act, as far as is known.

        Until then the commands act that are under way, with the accelerations they were made for.
        """
        time, q, v = measurement.time, measurement.q, measurement.v
        late = self._whole + self.ticks
        under_way = [(command, self._tick) for command in [*self._sent][:late]]
        if self._part and len(self._sent) > late:
            under_way.append((self._sent[late], self._part * self._tick))
        for command, duration in reversed(under_way):
            after = v + command.acceleration * duration
            q = body.moved(q, (v + after) / 2 * duration)
            time, v = time + duration, after
        return Measurement(time, q, v, measurement.torque)
