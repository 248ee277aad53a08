"""A tab's lanes in the pool: what runs beside each other, one job of a lane at a time."""

from __future__ import annotations

from enum import Enum


class Lane(Enum):
    """Jobs of one lane replace each other; those of different lanes do not wait for each other."""

    MOTION = "motion"
    ROBOT = "robot"
    OPEN = "open"
    SAVE = "save"
