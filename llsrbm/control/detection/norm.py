"""The paper's detector: ‖v_G‖ falls in every tick of a sampling window."""

from __future__ import annotations

from llsrbm.control.detection.base import ARMED_BELOW, CentroidalState, Detector

# ‖v_G‖ changes by -30 to -165 /s in an impact and by +9.81 /s at most in free fall.
THRESHOLD = -8.0  # m/s2 and rad/s2 in one norm
WINDOW = 0.0075  # s: three ticks at 400 Hz


class NormDetector(Detector):
    """Contact when all numerical derivatives of ‖v_G‖ in a window are below a threshold.

    Blind to impacts in which the norm rises: a robot that lands with its CoM behind its feet
    pitches faster than it loses speed.
    """

    name = "norm"
    summary = "the paper's: ‖v_G‖ falls fast in every tick of a window"

    def __init__(self, tick: float) -> None:
        self.threshold = -THRESHOLD
        self._window = max(1, round(WINDOW / tick))
        super().__init__(tick)

    def reset(self) -> None:
        """See `Detector.reset`."""
        self.signal = 0.0
        self._last_norm: float | None = None
        self._rates: list[float] = []

    def update(self, state: CentroidalState) -> bool:
        """See `Detector.update`."""
        norm = state.average_spatial_velocity_norm
        if self._last_norm is not None:
            self._rates.append((norm - self._last_norm) / self.tick)
            del self._rates[: -self._window]
        self._last_norm = norm
        if len(self._rates) < self._window:
            return False
        self.signal = -max(self._rates)
        armed = float(state.com_velocity[2]) < ARMED_BELOW
        return armed and self.signal > self.threshold
