"""Contact forces estimated from joint torques and velocities: which feet have found the ground."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from llsrbm.control.whole_body import WholeBody

Array = NDArray[np.float64]

_BASE = 6
_SMOOTHING = 0.5  # share of the newest tick; one tick's difference of noisy velocities is 10 N off
_TOUCHING = 0.06  # of the robot's weight, N: twice what noise and a wrong trunk mass make of a leg
_SURE = 2  # ticks in a row


class FootForces:
    """A leg's joint equations, solved for the force at its foot.

        J^T f = M_leg dv/dt + h_leg - tau_leg

    with the difference of two measured velocities for dv/dt.

    Attributes:
        vertical: (L,) N, smoothed.
    """

    def __init__(self, body: WholeBody, legs: NDArray[np.int64], tick: float) -> None:
        """Nothing is known before the second `update`.

        Args:
            body: the robot.
            legs: (L, n) places of each leg's joints among all joints.
            tick: s between updates.
        """
        self._body, self._tick = body, tick
        self._rows = legs + _BASE
        self._threshold = _TOUCHING * body.mass * 9.81
        self._equations: tuple[Array, Array, Array, Array] | None = None
        self.vertical = np.zeros(body.legs)
        self._touching = np.zeros(body.legs, dtype=np.int64)

    def reset(self) -> None:
        """Forget what was measured."""
        self._equations = None
        self.vertical[:] = 0.0
        self._touching[:] = 0

    def update(self, torque: Array) -> NDArray[np.bool_]:
        """Which feet carry load, (L,).

        Args:
            torque: (J,) measured, mean of the tick that ended.
        """
        body = self._body
        if self._equations is not None:
            M, h, J, v = self._equations
            load = M @ (body.v - v) / self._tick + h
            load[_BASE:] -= torque
            legs = np.take_along_axis(J, self._rows[:, None, :].repeat(3, axis=1), axis=2)
            rhs = np.einsum("lij,lj->li", legs, load[self._rows])
            force = np.linalg.solve(
                legs @ legs.transpose(0, 2, 1) + 1e-6 * np.eye(3), rhs[..., None]
            )
            self.vertical += _SMOOTHING * (force[:, 2, 0] - self.vertical)
            above = self.vertical > self._threshold
            self._touching = np.where(above, self._touching + 1, 0)
        self._equations = (body.M.copy(), body.h, body.foot_jacobian.copy(), body.v.copy())
        touching: NDArray[np.bool_] = self._touching >= _SURE
        return touching
