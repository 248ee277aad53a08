"""Feet that have left the ground by the plan's clock, and touch it still."""

import math
from typing import NamedTuple

import numpy as np

from llsrbm.arrays import Array
from llsrbm.control.reference import Target
from llsrbm.control.whole_body import WholeBody


class Leaving(NamedTuple):
    """How feet leave the ground that are lower than `low`, m, for `lasts`, s, after lift-off.

    They go straight up, at least at `rising`, m/s.
    """

    low: float
    lasts: float
    rising: float


# Ground and drives give way, so feet carry load for up to 25 ms after lift-off. A swing that begins
# then drags them: 28 N, at the friction's limit, gave a Go2 that twists 128 degrees 0.17 Nms of
# roll, and it came down leaning by 22 degrees. Feet that rise at 0.5 m/s carry as long.
SWINGING = Leaving(low=0.003, lasts=0.05, rising=1.5)
# Legs that have pushed a body over stop their sweep of 20 rad/s, and their rotors', as they leave:
# dragged over the ground feet take 6 % of a front flip's momentum. They rise by themselves: where
# they had to rise as above 13 of 20 front flips were strict, and without 15.
SWEEPING = Leaving(low=0.02, lasts=0.0045, rising=-math.inf)


def leaving(way: Leaving, target: Target, body: WholeBody, since: float, ground: Array) -> Target:
    """A target in flight, of which feet that are on the ground still go straight up.

    `since`: lift-off, s; `ground`: (L,) m, height under the feet.
    """
    if since >= way.lasts:
        return target
    low = body.foot[:, 2] < ground + way.low
    if not low.any():
        return target
    rising = np.array([0.0, 0.0, way.rising]) - body.com_velocity
    straight = low[:, None] & [True, True, False]
    straight[:, 2] = low & (target.foot_velocity_from_com[:, 2] < rising[2])
    return target._replace(
        foot_from_com=np.where(straight, body.foot - body.com, target.foot_from_com),
        foot_velocity_from_com=np.where(straight, rising, target.foot_velocity_from_com),
        foot_acceleration_from_com=np.where(straight, 0.0, target.foot_acceleration_from_com),
    )
