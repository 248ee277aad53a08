"""Frames that differ by a turn about the vertical and a shift; the one that brings feet to feet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from llsrbm.arrays import Array
from llsrbm.mechanics import quaternion_product, quaternions_about_z, turns_about_z


@dataclass(frozen=True, eq=False)
class Frame:
    """An inner frame in an outer one: `yaw` rad about the vertical, then `origin` (3,) m.

    A repair's is the project's frame in the file's.
    """

    yaw: float
    origin: Array

    def points(self, points: Array) -> Array:
        """Points (..., 3) m of the outer frame, in the inner one."""
        return (points - self.origin) @ turns_about_z(self.yaw)

    def attitudes(self, quat: Array) -> Array:
        """Attitudes (..., 4) of the outer frame, in the inner one."""
        return quaternion_product(_about_z(-self.yaw, quat), quat)

    def back(self, points: Array) -> Array:
        """Points (..., 3) m of the inner frame, in the outer one."""
        return self.turned_back(points) + self.origin

    def turned_back(self, vectors: Array) -> Array:
        """Vectors (..., 3) of the inner frame, in the outer one's axes."""
        return vectors @ turns_about_z(self.yaw).T

    def attitudes_back(self, quat: Array) -> Array:
        """Attitudes (..., 4) of the inner frame, in the outer one."""
        return quaternion_product(_about_z(self.yaw, quat), quat)

    def after(self, inner: Frame) -> Frame:
        """The frame that is `inner` in this one, in this one's outer frame."""
        return Frame(self.yaw + inner.yaw, self.back(inner.origin))


def frame_between(feet: Array, there: Array) -> Frame:
    """The frame in which feet (L, 3) m are nearest to where others (L, 3) m are in its outer one.

    The turn and the shift have the least sum of squares, seen from above; heights agree on average.
    """
    middle, goal = feet.mean(axis=0), there.mean(axis=0)
    a, b = (feet - middle)[:, :2], (there - goal)[:, :2]
    turn = float(np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum()))
    return Frame(turn, goal - turns_about_z(turn) @ middle)


def _about_z(angle: float, quat: Array) -> Array:
    return np.broadcast_to(quaternions_about_z(angle), quat.shape)
