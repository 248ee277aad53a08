"""The request: which robot jumps where, and the model the planner shall believe in."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from llsrbm.errors import InputError

AMOUNTS = ("twist", "forward", "lateral", "height", "roll", "pitch", "speed", "end_speed")
"""Fields of a `Jump` that are numbers."""

ASKABLE = ("roll", "pitch", "speed", "end_speed", "hops")
"""Fields of a `Jump` beyond where to land, which a jump type may ask for."""

MOST_HOPS = 5
_WHOLE = 1e-3  # of a turn: as near as degrees on a command line are


@dataclass(frozen=True)
class Jump:
    """One jump, from the robot's default posture to the same posture elsewhere.

    Attributes:
        robot: a robot's name (`llsrbm.robots.names()`) or the path of a robot file.
        model: a model's name (`llsrbm.models.names()`).
        twist: rotation about the vertical, rad, positive to the left.
        forward: displacement along x, m (world = heading at the start).
        lateral: displacement along y, m, positive to the left.
        height: height of the landing surface above the ground at the start, m.
        type: a jump type's name (`llsrbm.request.jump_types.names()`) or the path of its TOML file.
        roll, pitch: whole turns about the body's x and y axes, right-hand rule, rad: a front flip
            is +2 pi of pitch, a back flip -2 pi.
        speed: forward speed of the CoM at the start, m/s.
        end_speed: forward speed at the end, along the landing heading, m/s.
        hops: number of jumps in a row, each as far as the displacement says.
    """

    robot: str = "anymal"
    model: str = "llsrbm-plus"
    twist: float = 0.0
    forward: float = 0.0
    lateral: float = 0.0
    height: float = 0.0
    type: str = "together"
    roll: float = 0.0
    pitch: float = 0.0
    speed: float = 0.0
    end_speed: float = 0.0
    hops: int = 1

    def __post_init__(self) -> None:
        for name in AMOUNTS:
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise InputError(
                    f"Jump.{name}: expected a number, got {type(value).__name__} {value!r}"
                )
            if not math.isfinite(value):
                raise InputError(f"Jump.{name}: expected a finite number, got {value}")
            object.__setattr__(self, name, float(value))
        for name in ("roll", "pitch"):
            turns = getattr(self, name) / (2 * math.pi)
            if abs(turns - round(turns)) > _WHOLE:
                raise InputError(
                    f"Jump.{name}: {math.degrees(getattr(self, name)):g} deg; expected whole "
                    "turns: -360, 0 or 360 deg"
                )
        if isinstance(self.hops, bool) or not isinstance(self.hops, int):
            raise InputError(f"Jump.hops: expected a whole number, got {self.hops!r}")
        if not 1 <= self.hops <= MOST_HOPS:
            raise InputError(f"Jump.hops: expected 1 to {MOST_HOPS}, got {self.hops}")
        for name in ("robot", "model", "type"):
            value = getattr(self, name)
            if not isinstance(value, str) or not value:
                raise InputError(f"Jump.{name}: expected a name, got {value!r}")

    @property
    def turns(self) -> bool:
        """Whether the body turns over: a whole turn of roll or pitch."""
        return bool(self.roll or self.pitch)

    def as_dict(self) -> dict[str, Any]:
        """The request as plain data, for files and messages."""
        return asdict(self)
