"""Attitudes of things that point somewhere."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def z_to(along: Array) -> Array:
    """Quaternions (F, 4) that turn z to the directions `along` (F, 3), the short way."""
    z = along / np.linalg.norm(along, axis=1, keepdims=True)
    wxyz = np.stack([1 + z[:, 2], -z[:, 1], z[:, 0], np.zeros(len(z))], axis=1)
    # Straight down, any half turn about a horizontal axis.
    wxyz[z[:, 2] < -1 + 1e-9] = [0.0, 1.0, 0.0, 0.0]
    turned: Array = wxyz / np.linalg.norm(wxyz, axis=1, keepdims=True)
    return turned


def x_to(along: Array) -> Array:
    """Quaternions (F, 4) that turn x to the directions `along` (F, 3) and keep y level."""
    yaw = np.arctan2(along[:, 1], along[:, 0]) / 2
    pitch = -np.arctan2(along[:, 2], np.linalg.norm(along[:, :2], axis=1)) / 2
    cy, sy, cp, sp = np.cos(yaw), np.sin(yaw), np.cos(pitch), np.sin(pitch)
    return np.stack([cy * cp, -sy * sp, cy * sp, sy * cp], axis=1)
