"""Slopes of the surfaces that a robot takes off from and lands on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from llsrbm.arrays import Array
from llsrbm.mechanics import rotation_matrices, turned_to, turns_about_z

if TYPE_CHECKING:
    from llsrbm.request.jump import Jump


_LEVEL = 1e-12  # square of a gradient below which a surface is level


def gradient(slope: float, cross_slope: float, heading: float) -> Array:
    """(2,) by how much a surface rises along the world's x and y axes.

    It rises ahead, and to the left, by angles (rad) as a robot sees it that looks along `heading`.
    """
    ahead, left = math.tan(slope), math.tan(cross_slope)
    c, s = math.cos(heading), math.sin(heading)
    return np.array([c * ahead - s * left, s * ahead + c * left])


def normals(gradients: Array) -> Array:
    """Unit normals (..., 3) of surfaces with gradients (..., 2); level ones point up."""
    up = np.concatenate([-gradients, np.ones((*gradients.shape[:-1], 1))], axis=-1)
    unit: Array = up / np.linalg.norm(up, axis=-1, keepdims=True)
    return unit


def leaning(gradients: Array) -> Array:
    """Quaternions (..., 4) w, x, y, z that turn what is level onto surfaces, the short way."""
    return turned_to(normals(gradients), 2)


def surface_axes(normals: Array) -> Array:
    """R_world_surface (..., 3, 3) of unit normals (..., 3), the last column: see
    `llsrbm.planning.problem.rotations.on_surface`.
    """
    fall = normals[..., :2]
    angle = np.arctan2(-fall[..., 1], -fall[..., 0]) - np.pi / 4
    level = (fall**2).sum(axis=-1) < _LEVEL
    turn = turns_about_z(np.where(level, 0.0, angle))
    axes: Array = rotation_matrices(turned_to(normals, 2)) @ turn
    return axes


def gradients(jump: Jump, places: int, headings: Sequence[float]) -> list[Array]:
    """(2,) of the surface of the start and of each of so many places after it; headings in rad."""
    each = zip(slopes_of(jump, places), headings, strict=True)
    return [gradient(*slopes, heading) for slopes, heading in each]


def slopes_of(jump: Jump, places: int) -> list[tuple[float, float]]:
    """Slope and cross slope, rad, of the start and of each of so many places after it."""
    landings = [(each.slope, each.cross_slope) for each in jump.route or [jump] * places]
    return [(jump.takeoff_slope, jump.takeoff_cross_slope), *landings]
