"""What a task of the whole-body controller is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from llsrbm.control.reference import Target
from llsrbm.control.whole_body import WholeBody

Array = NDArray[np.float64]


class Motion(NamedTuple):
    """How m task coordinates x move, n velocities v of the robot.

    Attributes:
        jacobian: (m, n): the coordinates' rate is `jacobian @ v`.
        bias: (m,) their acceleration at zero `dv/dt`.
        error: (m,) wanted minus actual.
        error_rate: (m,) wanted minus actual rate.
        feedforward: (m,) wanted acceleration.
    """

    jacobian: Array
    bias: Array
    error: Array
    error_rate: Array
    feedforward: Array


class Task(ABC):
    """A wish for some accelerations: J dv/dt + bias = feedforward + kp error + kd error_rate.

    The paper's section V; it is fulfilled as far as its weight says.
    """

    rows: int

    def __init__(self, gains: tuple[float, float]) -> None:
        """Gains: stiffness, 1/s2, and damping, 1/s."""
        self._stiffness, self._damping = gains

    @abstractmethod
    def motion(self, body: WholeBody, target: Target) -> Motion:
        """The task's coordinates as they are, and as they should be."""

    def write(self, body: WholeBody, target: Target, jacobian: Array, command: Array) -> None:
        """Fill `jacobian` (rows, n) and the accelerations wanted of dv/dt, `command` (rows,)."""
        m = self.motion(body, target)
        jacobian[:] = m.jacobian
        np.multiply(m.error_rate, self._damping, out=command)
        if self._stiffness:
            command += self._stiffness * m.error
        command += m.feedforward
        command -= m.bias
