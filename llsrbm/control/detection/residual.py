"""The vector residual: how far the centroidal velocity has left what gravity alone makes of it."""

from __future__ import annotations

from collections import deque

import numpy as np

from llsrbm.control.detection.base import ARMED_BELOW, GRAVITY, Array, CentroidalState, Detector

WINDOW = 0.020  # s over which the residual is taken
THRESHOLD = 0.08  # m/s and rad/s in one norm
CONSECUTIVE = 2  # ticks above the threshold


class ResidualDetector(Detector):
    """Contact when the residual over a window is above its threshold in consecutive ticks."""

    name = "residual"
    summary = "change of linear and angular velocity beyond gravity's (the default)"

    def __init__(self, tick: float) -> None:
        self.threshold = THRESHOLD
        self._window = round(WINDOW / tick)
        super().__init__(tick)

    def reset(self) -> None:
        """See `Detector.reset`."""
        self.signal = 0.0
        self._past: deque[tuple[Array, Array]] = deque(maxlen=self._window)
        self._above = 0

    def update(self, state: CentroidalState) -> bool:
        """See `Detector.update`."""
        full = len(self._past) == self._window
        if full:
            velocity, momentum = self._past[0]
            linear = state.com_velocity - velocity
            linear[2] += GRAVITY * self.tick * self._window
            angular = np.linalg.solve(state.inertia, state.angular_momentum - momentum)
            self.signal = float(np.sqrt(linear @ linear + angular @ angular))
        self._past.append((state.com_velocity.copy(), state.angular_momentum.copy()))
        self._above = self._above + 1 if full and self.signal > self.threshold else 0
        return self._above >= CONSECUTIVE and float(state.com_velocity[2]) < ARMED_BELOW
