"""The request: which robot jumps where, and the model the planner shall believe in."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from llsrbm.errors import InputError


@dataclass(frozen=True)
class Jump:
    """One jump, from standing still in the robot's default posture to standing still.

    Attributes:
        robot: a robot's name (`llsrbm.robots.names()`) or the path of a robot file.
        model: a model's name (`llsrbm.models.names()`).
        twist: rotation about the vertical, rad, positive to the left.
        forward: displacement along x, m (world = heading at the start).
        lateral: displacement along y, m, positive to the left.
        height: height of the landing surface above the ground at the start, m.
    """

    robot: str = "anymal"
    model: str = "llsrbm-plus"
    twist: float = 0.0
    forward: float = 0.0
    lateral: float = 0.0
    height: float = 0.0

    def __post_init__(self) -> None:
        for name in ("twist", "forward", "lateral", "height"):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise InputError(
                    f"Jump.{name}: expected a number, got {type(value).__name__} {value!r}"
                )
            if not math.isfinite(value):
                raise InputError(f"Jump.{name}: expected a finite number, got {value}")
            object.__setattr__(self, name, float(value))
        for name in ("robot", "model"):
            value = getattr(self, name)
            if not isinstance(value, str) or not value:
                raise InputError(f"Jump.{name}: expected a name, got {value!r}")

    def as_dict(self) -> dict[str, Any]:
        """The request as plain data, for files and messages."""
        return asdict(self)
