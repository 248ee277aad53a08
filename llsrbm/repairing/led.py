"""A motion that leads less far: the same from place to place, with a share of each way and turn.

Where a robot cannot go all the way of a motion, the motion nearest to it goes some of it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from llsrbm.arrays import Array
from llsrbm.mechanics import apply, quaternion_product, quaternions_about_z, turns_about_z


@dataclass(frozen=True, eq=False)
class Way:
    """Where a robot stands, from place to place, in a file's frame.

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
        return replace(self, middles=middles, headings=headings)


@dataclass(frozen=True, eq=False)
class Led:
    """From a motion's own way to another one through as many places."""

    own: Way
    to: Way

    def points(self, at: Array, points: Array) -> Array:
        """Points (K, ..., 3) m that belong to places at (K,), between two on the way, there."""
        flat = points.reshape(len(at), -1, 3)
        middle, there = (self._middles(way, at)[:, None] for way in (self.own, self.to))
        turned = (flat - middle) @ np.swapaxes(turns_about_z(self.turns(at)), -1, -2)
        moved: Array = (turned + there).reshape(points.shape)
        return moved

    def attitudes(self, at: Array, quat: Array) -> Array:
        """Attitudes (K, 4) likewise."""
        return quaternion_product(quaternions_about_z(self.turns(at)), quat)

    def turns(self, at: Array) -> Array:
        """(K,) rad by which they are turned."""
        places = np.arange(len(self.own.headings))
        turned: Array = np.interp(at, places, self.to.headings - self.own.headings)
        return turned

    @staticmethod
    def _middles(way: Way, at: Array) -> Array:
        places = np.arange(len(way.middles))
        x, y = (np.interp(at, places, axis) for axis in way.middles.T)
        return np.stack([x, y, np.zeros_like(x)], axis=1)
