"""A motion led another way: with a share of each step and turn.

Where a robot cannot go all the way of a motion, the motion nearest to it goes some of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from llsrbm.arrays import Array
from llsrbm.mechanics import apply, quaternion_product, quaternions_about_z, turns_about_z


@dataclass(frozen=True, eq=False)
class Way:
    """Where a robot stands, from place to place or instant to instant, in a file's frame.

    Attributes:
        middles: (n, 2) m; headings: (n,) rad, whole turns counted.
    """

    middles: Array
    headings: Array

    @property
    def steps(self) -> Array:
        """(n - 1, 2) m ahead and to the left, from each place to the next."""
        back = np.swapaxes(turns_about_z(self.headings[:-1]), -1, -2)[:, :2, :2]
        return apply(back, np.diff(self.middles, axis=0))

    def shared(self, share: float) -> Way:
        """With a share of each step and each turn."""
        headings = self.headings[0] + share * (self.headings - self.headings[0])
        ahead = turns_about_z(headings[:-1])[:, :2, :2]
        steps = apply(ahead, share * self.steps)
        middles = np.vstack([self.middles[:1], self.middles[0] + np.cumsum(steps, axis=0)])
        return Way(middles, headings)

    def at(self, places: Array) -> Way:
        """On the way: at places (K,), which may be between two."""
        known = np.arange(len(self.headings))
        x, y, heading = (np.interp(places, known, v) for v in (*self.middles.T, self.headings))
        return Way(np.stack([x, y], axis=1), heading)


@dataclass(frozen=True, eq=False)
class Led:
    """From a motion's own way to another one, of as many places or instants."""

    own: Way
    to: Way

    def points(self, points: Array) -> Array:
        """Points (n, ..., 3) m that belong to these, there."""
        flat = points.reshape(len(points), -1, 3)
        flat = flat - _level(self.own.middles)
        turned = flat @ np.swapaxes(turns_about_z(self.turns), -1, -2)
        moved: Array = (turned + _level(self.to.middles)).reshape(points.shape)
        return moved

    def attitudes(self, quat: Array) -> Array:
        """Attitudes (n, 4) likewise."""
        return quaternion_product(quaternions_about_z(self.turns), quat)

    @property
    def turns(self) -> Array:
        """(n,) rad by which they are turned."""
        return self.to.headings - self.own.headings


def _level(middles: Array) -> Array:
    """(n, 1, 3) m of (n, 2)."""
    return np.pad(middles, [(0, 0), (0, 1)])[:, None]
