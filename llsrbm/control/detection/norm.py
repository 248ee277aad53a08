"""The paper's detector: ‖v_G‖ falls in every tick of a sampling window."""

from __future__ import annotations

import numpy as np

from llsrbm.control.detection.base import CentroidalState, Detector, ModelUncertainty

# m/s2 and rad/s2 in one norm. Free fall raises ‖v_G‖ by 9.81 at most and lowers it on the way up;
# measured with noise of 0.01 it falls by up to 7 in each of two ticks without contact.
THRESHOLD = -8.0
WINDOW = 0.005  # s: two ticks at 400 Hz; impacts on hard ground are over in three


class NormDetector(Detector):
    """Contact when all numerical derivatives of ‖v_G‖ in a window are below a threshold.

    Blind to impacts in which the norm rises: a robot that lands with its CoM behind its feet
    pitches faster than it loses speed. Of 300 simulated landings with noise it missed 54.
    """

    name = "norm"
    summary = "the paper's: ‖v_G‖ falls fast in every tick of a window"

    def __init__(self, tick: float, uncertainty: ModelUncertainty) -> None:
        self.threshold = -THRESHOLD
        self._window = max(1, round(WINDOW / tick))
        super().__init__(tick, uncertainty)

    def reset(self) -> None:
        super().reset()
        self._norms: list[float] = []

    def update(self, state: CentroidalState) -> bool:
        """See `Detector.update`; the signal is minus the greatest derivative in the window."""
        self._norms.append(state.average_spatial_velocity_norm)
        del self._norms[: -self._window - 1]
        if not self._falling(state) or len(self._norms) <= self._window:
            return False
        self.signal = -float(np.diff(self._norms).max()) / self.tick
        return self.signal > self.threshold
