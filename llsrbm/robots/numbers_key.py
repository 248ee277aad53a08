"""A key of a robot's numbers, for what was computed from them and is kept in a file."""

from __future__ import annotations

import json
from typing import Any

from llsrbm.cache import content_key
from llsrbm.robots.robot import Robot

NUMBERS = (
    *("limits", "reach", "timing", "foot", "task", "planning"),
    *("mass", "com", "inertia", "feet", "base_position", "hips", "mirrors", "joint_names"),
    *("armature", "joint_friction", "joint_damping"),
)
DIGITS = 6  # after the point; computed numbers differ from machine to machine


def numbers_key(robot: Robot) -> str:
    """The key of all numbers on which its plans depend."""
    numbers = robot.parameters()
    numbers = _rounded({name: numbers[name] for name in NUMBERS})
    return content_key(json.dumps(numbers, sort_keys=True)).hex()


def _rounded(data: Any) -> Any:
    """Plain data, its numbers with `DIGITS` digits after the point."""
    if isinstance(data, dict):
        return {key: _rounded(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_rounded(value) for value in data]
    return round(data, DIGITS) + 0.0 if isinstance(data, float) else data
