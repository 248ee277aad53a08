"""Requests for a library, drawn at random: the same draw of a robot is the same request.

Kinds of motions come in turn, so that whenever a build ends its motions are of all of them. A jump
by itself may ask for the range of the robot's file, each jump of several for a part of it.
"""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from llsrbm.request.jump import COMPONENTS, Jump
from llsrbm.request.jump_types import with_defaults
from llsrbm.request.route import Landing
from llsrbm.robots import load_robot

SEED = 46
IN_A_ROW = 0.5  # of the range: what each of several jumps may ask for
_TURN_IN_A_ROW = math.radians(60)  # rad, likewise
_DIGITS = 3  # of what is asked for, m and rad

# By how many feet: in which turn kinds come.
_QUADRUPEDS = (
    *("together", "hops", "rear-last", "together", "pirouette", "route"),
    *("together", "over-gap", "run-up"),
)
_BIPEDS = (
    *("together", "pirouette", "hops", "together", "one-foot-first", "together"),
    *("route", "over-gap"),
)
_OF_NO_TYPE = ("pirouette", "route")  # of their own, but of what is asked for


@dataclass(frozen=True)
class Draw:
    """A draw of a robot by its number."""

    robot: str
    number: int

    @property
    def kind(self) -> str:
        """The kind of motion that it is."""
        kinds = _QUADRUPEDS if len(load_robot(self.robot).legs) > 2 else _BIPEDS
        return kinds[self.number % len(kinds)]

    @property
    def jump(self) -> Jump:
        """The request."""
        own = zlib.crc32(self.robot.encode())
        drawing = _Drawing(self.robot, np.random.default_rng([SEED, own, self.number]))
        fields = getattr(drawing, self.kind.replace("-", "_"))()
        if self.kind in _OF_NO_TYPE:
            return Jump(robot=self.robot, **fields)
        return with_defaults(Jump(robot=self.robot, type=self.kind, **fields), fields)


class _Drawing:
    """Fields of requests, a method for each kind."""

    def __init__(self, robot: str, rng: np.random.Generator) -> None:
        task = load_robot(robot).file.task
        self._ranges = {name: getattr(task, name) for name in COMPONENTS}
        self._rng = rng

    def together(self) -> dict[str, Any]:
        """One component, or all of them."""
        values = {name: self._between(*self._ranges[name]) for name in COMPONENTS}
        if self._rng.random() < 0.5:
            return values
        name = str(self._rng.choice(COMPONENTS))
        return {name: values[name]}

    def pirouette(self) -> dict[str, Any]:
        """A turn of two thirds of the range or more, on the spot."""
        low, high = self._ranges["twist"]
        share = self._rng.uniform(0.67, 1.0)
        return {"twist": self._rounded(share * (low if self._rng.random() < 0.5 else high))}

    def hops(self) -> dict[str, Any]:
        """Two alike."""
        return self._in_a_row() | {"hops": 2}

    def route(self) -> dict[str, Any]:
        """Two that differ."""
        return {"route": tuple(Landing(**self._in_a_row()) for _ in range(2))}

    def rear_last(self) -> dict[str, Any]:
        """Forward, half of them up."""
        up = self._rng.random() < 0.5
        height = self._between(0.0, IN_A_ROW * self._ranges["height"][1]) if up else 0.0
        return {"forward": self._ahead(0.4, 0.95), "height": height}

    def run_up(self) -> dict[str, Any]:
        """Forward, at a speed at the start that fits the length."""
        forward = self._ahead(0.4, 0.85)
        return {"forward": forward, "speed": self._rounded(self._rng.uniform(1.0, 1.7) * forward)}

    def one_foot_first(self) -> dict[str, Any]:
        """On the spot, forward or backward."""
        low, high = self._ranges["forward"]
        return {"forward": self._between(0.3 * low, 0.5 * high)}

    def over_gap(self) -> dict[str, Any]:
        """All feet over a gap."""
        return {"gap": self._ahead(0.2, 0.55)}

    def _ahead(self, low: float, high: float) -> float:
        """A length between these shares of the range forward."""
        return self._rounded(self._rng.uniform(low, high) * self._ranges["forward"][1])

    def _in_a_row(self) -> dict[str, float]:
        found = {}
        for name in COMPONENTS:
            low, high = (IN_A_ROW * end for end in self._ranges[name])
            if name == "twist":
                low, high = max(low, -_TURN_IN_A_ROW), min(high, _TURN_IN_A_ROW)
            found[name] = self._between(low, high)
        return found

    def _between(self, low: float, high: float) -> float:
        return self._rounded(self._rng.uniform(low, high))

    def _rounded(self, value: float) -> float:
        return round(float(value), _DIGITS)
