"""A handle that is dragged, without a page."""

import contextlib
import math
from types import SimpleNamespace

import numpy as np


class Gizmo(SimpleNamespace):
    """What viser's handle offers of itself."""

    def on_update(self, callback):
        self.callback = callback

    def drag(self, phase="update"):
        with contextlib.suppress(StopIteration):  # it waits for nothing
            self.callback(SimpleNamespace(phase=phase)).send(None)

    def place(self, x, y, yaw):
        self.position = np.array([x, y, 0.0])
        self.wxyz = np.array([math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)])
