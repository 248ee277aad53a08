from __future__ import annotations

import numpy as np
import pytest

from app.overlays import top_under
from llsrbm.simulation.surroundings import Block


def test_the_blot_lies_on_what_is_below():
    block = Block(
        "box",
        centre=np.array([1.0, 0.0, 0.1]),
        size=np.array([1.0, 0.2, 0.2]),
        yaw=np.radians(90),
        from_s=0.5,
    )

    def below(x, y, time):
        return top_under([block], np.array([x, y, 0.9]), time, -0.1)

    assert below(1.0, 0.4, 0.6) == pytest.approx(0.2)
    assert below(1.0, 0.4, 0.4) == -0.1  # it is not there yet
    assert below(1.4, 0.0, 0.6) == -0.1  # it is turned: short along x
    assert below(1.0, -0.6, 0.6) == -0.1
