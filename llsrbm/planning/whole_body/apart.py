"""Distances between links in the air, as straight functions of the joints about a motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from llsrbm.planning.whole_body.grid import Grid, Sizes
from llsrbm.robots.near_links import NearLinks
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]

NEAR = 0.15  # m: links farther apart do not meet as the second stage moves them
LEAST = 0.005  # m that links may be apart


@dataclass(frozen=True, eq=False)
class Apart:
    """At the knots of N intervals and in the middles between them, of n pairs of links.

    Attributes:
        least: (2 N + 1,) m of the nearest pair, infinite where nothing is near or no foot flies.
        at_zero: (2 N + 1, n) m that a pair would be apart with all joints at zero.
        slope: (2 N + 1, n, J) m per rad or m.
    """

    least: Array
    at_zero: Array
    slope: Array

    @classmethod
    def near(cls, joints: Array, robot: Robot, grid: Grid) -> Apart:
        """About postures (2 N + 1, J)."""
        sizes = Sizes.of(robot)
        flies = np.zeros(len(joints), dtype=bool)
        flies[::2] = [len(knot.resting) < sizes.legs for knot in grid.knots]
        flies[1::2] = [len(knot.standing) < sizes.legs for knot in grid.knots[:-1]]
        base = np.tile(robot.posture[:7], (int(flies.sum()), 1))  # distances do not depend on it
        q = np.hstack([base, joints[flies]])
        distance = np.full((len(joints), sizes.near), np.inf)
        slope = np.zeros((*distance.shape, sizes.joints))
        distance[flies], slope[flies] = NearLinks.of(robot).soonest(q, sizes.near, NEAR)
        at_zero = distance - np.einsum("knj,kj->kn", slope, joints)
        return cls(distance.min(axis=1), at_zero, slope)

    @property
    def holds(self) -> bool:
        """True if no links are nearer than they may be."""
        return bool((self.least >= LEAST).all())
