"""A made-up classifier whose border is known."""

from collections.abc import Iterator
from contextlib import contextmanager
from unittest.mock import patch

import numpy as np

from llsrbm.atlas import feasible
from llsrbm.atlas.feasible import LIMITS, feasible_of, features
from llsrbm.request.jump import COMPONENTS
from llsrbm.robots.numbers_key import numbers_key
from llsrbm.robots.robot import Robot

FULL = 0.8
"""Share of the torque from which the whole twist can be planned."""

STEEP = 10.0


def border(share: float) -> float:
    """The largest twist that can be planned, as a share of its range."""
    low, high = LIMITS["torque_share"]
    return float(np.sqrt(1 + 2 * (share - FULL) / (high - low)))


def weights() -> list[float]:
    """Of the score STEEP (border(share)^2 - twist^2), twist as a share of its range."""
    names, (low, high) = [*COMPONENTS, *LIMITS], LIMITS["torque_share"]
    x = np.random.default_rng(0).uniform(-1, 1, (1000, len(names)))
    twist, share = x[:, names.index("twist")], x[:, names.index("torque_share")]
    full = 2 * (FULL - low) / (high - low) - 1
    score = STEEP * (1 + share - full - twist**2)
    return np.linalg.lstsq(features(x), score, rcond=None)[0].tolist()


@contextmanager
def shipped(*robots: Robot) -> Iterator[None]:
    """It ships of some robots, of no other one, until the block ends."""
    data = {robot.name: {"robot": numbers_key(robot), "weights": weights()} for robot in robots}
    with patch.object(feasible, "_file", lambda: data):
        feasible_of.cache_clear()
        try:
            yield
        finally:
            feasible_of.cache_clear()
