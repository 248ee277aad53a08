"""The vector residual: how far the centroidal motion has left what gravity alone makes of it.

In free fall v_com + g t and the angular momentum L are constant, so their means over the last k
ticks and over a baseline just before differ by noise alone. A contact adds its impulse J to both,

    dv = J / m,    dw = I^-1 (r x J),

in any direction, hence the norm of both; and an unknown number of ticks ago, hence every k up to a
longest window (a generalised likelihood ratio test): a stiff contact shows in one tick, a soft one
needs the mean of several. The signal is the largest of these differences in units of what is to be
expected without contact,

    max_k |[dv_k / s_v; dw_k / s_w]|,    s^2 = noise^2 (1/k + 1/baseline) + model^2,

with the noise of this flight, measured on the way up, and an allowance for a wrong model. What is
conserved in the air belongs to the true masses. Where the trunk is heavier than believed by a share
e of its mass, the believed v_com and L lack e times the trunk's own momenta about the CoM, h and l:
to first order in e,

    v_com + e h / m  and  L + e l   are conserved,

so the legs' swing makes dv = -e dh / m and dw = -e I^-1 dl without any contact, the more the faster
the trunk is moved against the CoM. With e known to a standard deviation only,

    model_v^2 = MODEL_ERROR^2 + std(e)^2 |dh / m|^2,
    model_w^2 = MODEL_ERROR^2 + std(e)^2 |I^-1 dl|^2

in every direction alike, since a payload may sit anywhere on the trunk.
"""

from __future__ import annotations

import numpy as np

from llsrbm.control.detection.base import Array, CentroidalState, Detector, ModelUncertainty
from llsrbm.mechanics import GRAVITY

# Standard deviations. Six components of white noise exceed 8 in 1 of 1e11 tests; the worst of 450
# simulated flights with noise and a trunk mass wrong by 8 to 15 %, 10 % being stated, came to 6.0.
THRESHOLD = 8.0
LONGEST_WINDOW = 0.020  # s; contacts so soft that they need more reach the threshold soon after
BASELINE = 0.040  # s: twice that, so that its own noise matters little
# m/s and rad/s by which the means may be wrong with the right masses: what the time steps of the
# controller and of the world make of a smooth motion.
MODEL_ERROR = 0.002
# A squared second difference in 3 dimensions is 6 noise^2 times chi-squared with 3 degrees of
# freedom, whose median is 2.366.
_MEDIAN = 6 * 2.366


class ResidualDetector(Detector):
    """Contact when a window of any length differs from the baseline before it.

    The signal is dimensionless: standard deviations.
    """

    name = "residual"
    summary = "change of linear and angular velocity that gravity does not explain (the default)"

    def __init__(self, tick: float, uncertainty: ModelUncertainty) -> None:
        self.threshold = THRESHOLD
        self._window = np.arange(1, max(1, round(LONGEST_WINDOW / tick)) + 1)
        self._baseline = max(2, round(BASELINE / tick))
        self._variance = (1 / self._window + 1 / self._baseline)[:, None]
        super().__init__(tick, uncertainty)

    def reset(self) -> None:
        super().reset()
        self._ticks = 0
        # v + g t, L, trunk's h / m and l; oldest first.
        self._recent = np.zeros((len(self._window) + self._baseline, 12))
        self._second_differences: list[tuple[float, float]] = []
        self._noise = np.zeros(2)

    def update(self, state: CentroidalState) -> bool:
        """See `Detector.update`; the signal is 0 until the detector listens."""
        recent = self._recent
        recent[:-1] = recent[1:]
        recent[-1, :3] = state.com_velocity
        recent[-1, 2] += GRAVITY * self.tick * self._ticks
        recent[-1, 3:6] = state.angular_momentum
        recent[-1, 6:9] = state.trunk_momentum[:3] / state.mass
        recent[-1, 9:] = state.trunk_momentum[3:]
        self._ticks += 1
        inverse = state.inverse_inertia
        listening = self._falling(state) and self._ticks >= len(recent)
        if not listening:
            self._measure_noise(inverse)
            return False
        if self._second_differences:
            self._noise = self._noise_so_far()
            self._second_differences.clear()
        self.signal = self._largest_difference(inverse)
        return self.signal > self.threshold

    def _measure_noise(self, inverse: Array) -> None:
        """Second differences hold noise alone: motions are smooth over three ticks."""
        if self._ticks >= 3:
            a, b, c = self._recent[-3:]
            d = c - 2 * b + a
            linear, angular = d[:3], inverse @ d[3:6]
            self._second_differences.append((linear @ linear, angular @ angular))

    def _noise_so_far(self) -> Array:
        """Standard deviation a component, m/s and rad/s.

        By the median, because feet that leave the ground late are no noise.
        """
        median = np.median(self._second_differences, axis=0)
        return np.sqrt(median / _MEDIAN)

    def _largest_difference(self, inverse: Array) -> float:
        k, before = self._window, self._baseline
        total = np.zeros((len(self._recent) + 1, 12))
        np.cumsum(self._recent, axis=0, out=total[1:])
        start = len(self._recent) - k
        late = (total[-1] - total[start]) / k[:, None]
        early = (total[start] - total[start - before]) / before
        difference = late - early
        # (windows, 4, 3) m/s, rad/s: dv, dw, and what a trunk of twice the mass adds to each.
        difference = difference.reshape(-1, 4, 3)
        difference[:, 1::2] = difference[:, 1::2] @ inverse
        squares = (difference * difference).sum(axis=2)
        model = MODEL_ERROR**2 + self.uncertainty.trunk_mass**2 * squares[:, 2:]
        variance = self._noise**2 * self._variance + model  # (windows, 2)
        return float(np.sqrt((squares[:, :2] / variance).sum(axis=1).max()))
