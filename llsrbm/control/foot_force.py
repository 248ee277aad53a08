"""Contact forces estimated from joint torques and velocities: which feet have found the ground."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dposv

from llsrbm.control.felt_impulse import FeltImpulse
from llsrbm.control.whole_body import WholeBody
from llsrbm.mechanics import GRAVITY

Array = NDArray[np.float64]

_BASE = 6
_REGULARISATION = 1e-6 * np.eye(3)  # m2, for legs that are stretched out
_SMOOTHING = 0.5  # share of the newest tick; one tick's difference of noisy velocities is 10 N off
# Of the robot's weight: twice what noise makes of a leg; the trunk's mass is not in its equations.
_TOUCHING = 0.06
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
        # Each leg's own columns of the feet's Jacobians, (L, 3, n).
        self._columns = (
            np.arange(body.legs)[:, None, None],
            np.arange(3)[None, :, None],
            self._rows[:, None, :],
        )
        # The legs' systems, one block each of one that is solved at a stroke: (3 L, 3 L).
        self._system = np.zeros((3 * body.legs, 3 * body.legs))
        row, column = self._system.strides
        self._blocks = np.lib.stride_tricks.as_strided(
            self._system, (body.legs, 3, 3), (3 * (row + column), row, column)
        )
        self._threshold = _TOUCHING * body.mass * GRAVITY
        self._equations: tuple[Array, Array, Array, Array] | None = None
        self.vertical = np.zeros(body.legs)
        self._felt = FeltImpulse(body.mass, tick)
        self._touching = np.zeros(body.legs, dtype=np.int64)

    def reset(self) -> None:
        """Forget what was measured."""
        self._equations = None
        self.vertical[:] = 0.0
        self._felt.reset()
        self._touching[:] = 0

    def update(self, torque: Array) -> NDArray[np.bool_]:
        """Which feet carry load, (L,).

        Args:
            torque: (J,) measured, mean of the tick that ended.
        """
        body = self._body
        if self._equations is not None:
            M, h, own, v = self._equations
            load = M @ (body.v - v) / self._tick + h
            load[_BASE:] -= torque
            np.add(own @ own.transpose(0, 2, 1), _REGULARISATION, out=self._blocks)
            force = dposv(self._system, (own @ load[self._rows][..., None]).ravel())[1]
            # Not smoothed: the errors of its sum over ticks cancel.
            self._felt.update(body.com_velocity, force.reshape(-1, 3).sum(axis=0))
            self.vertical += _SMOOTHING * (force[2::3] - self.vertical)
            above = self.vertical > self._threshold
            self._touching = np.where(above, self._touching + 1, 0)
        self._equations = (body.M, body.h, body.foot_jacobian[self._columns], body.v.copy())
        touching: NDArray[np.bool_] = self._touching >= _SURE
        return touching

    def met_ground(self) -> bool:
        """Whether it was with the feet that the robot hit what it has hit in the air."""
        return self._felt.is_ground()
