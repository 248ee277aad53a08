"""The vector residual: how far the centroidal motion has left what gravity alone makes of it.

In free fall v_com + g t and the angular momentum L are constant, so their means over the last k
ticks and over a baseline just before differ by noise alone. A contact adds its impulse to both,

    dv = J / m,    dw = I^-1 (r x J),

in any direction, hence the norm of both; and after an unknown number of ticks, hence every k up to
a longest window (a generalised likelihood ratio test): a stiff contact shows in one tick, a soft one
needs the average of several. The signal is the largest of these differences in units of its own
standard deviation,

    max_k |[dv_k / s_v; dw_k / s_w]|,    s^2 = noise^2 (1/k + 1/baseline) + model^2,

with the noise of this flight, measured on the way up, and an allowance for a wrong model: with a
wrong trunk mass the legs' swing moves the CoM that the controller believes in.
"""

from __future__ import annotations

import numpy as np

from llsrbm.control.detection.base import ARMED_BELOW, GRAVITY, Array, CentroidalState, Detector

# With 6 components of white noise 8 standard deviations are exceeded in 1 of 1e11 tests; the worst
# of 300 recorded flights with a wrong trunk mass came to 6.
THRESHOLD = 8.0
LONGEST_WINDOW = 0.020  # s: softer contacts than this are over the threshold all the same
BASELINE = 0.040  # s: twice that, so that its own noise matters little
# m/s and rad/s by which a trunk that is 8 % lighter or heavier shifts the difference of two windows,
# at most 0.012 in twists, over the threshold, with as much again to spare.
MODEL_ERROR = 0.003
# Median of chi-squared with 3 degrees of freedom, times 6, the variance of a second difference.
_MEDIAN_OF_SECOND_DIFFERENCES = 6 * 2.366


class ResidualDetector(Detector):
    """Contact when a window of any length differs from the baseline before it.

    The signal is dimensionless: standard deviations.
    """

    name = "residual"
    summary = "change of linear and angular velocity that gravity does not explain (the default)"

    def __init__(self, tick: float) -> None:
        self.threshold = THRESHOLD
        self._window = np.arange(1, max(1, round(LONGEST_WINDOW / tick)) + 1)
        self._baseline = max(2, round(BASELINE / tick))
        self._variance = (1 / self._window + 1 / self._baseline)[:, None]
        super().__init__(tick)

    def reset(self) -> None:
        """See `Detector.reset`."""
        self.signal = 0.0
        self._recent = np.zeros((len(self._window) + self._baseline, 6))  # v + g t, L; oldest first
        self._second_differences: list[tuple[float, float]] = []
        self._noise: Array | None = None
        self._ticks = 0

    def update(self, state: CentroidalState) -> bool:
        """See `Detector.update`."""
        rising = float(state.com_velocity[2]) >= ARMED_BELOW
        recent = self._recent
        recent[:-1] = recent[1:]
        recent[-1, :3] = state.com_velocity
        recent[-1, 2] += GRAVITY * self.tick * self._ticks
        recent[-1, 3:] = state.angular_momentum
        self._ticks += 1
        inverse = np.linalg.inv(state.inertia)
        if rising and self._noise is None:
            self._measure_noise(inverse)
        if self._ticks < len(recent):
            return False
        if self._noise is None:
            self._noise = self._noise_of_the_ascent()
        self.signal = self._largest(inverse, self._noise)
        return not rising and self.signal > self.threshold
