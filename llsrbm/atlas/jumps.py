"""The jumps of a sweep: request and result of each, its seeds together."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from llsrbm.arrays import Array, IntArray
from llsrbm.request.jump import Jump
from llsrbm.sweep.rows import LIMIT, NOT_PLANNED

NOTHING = ""
"""The limiting constraint of a jump that is feasible: none."""

FALLS = "falls in simulation"
"""The limiting constraint of a jump that is planned, and after which the robot falls."""

AMOUNTS = ("twist", "forward", "lateral", "height", "roll", "pitch", "speed", "end_speed", "hops")
DRIVES = ("drive_torque", "drive_speed")
"""Columns of a sweep's table of the request, limits aside."""


@dataclass(frozen=True)
class Axis:
    """Something that a sweep varies."""

    name: str  # the column's
    title: str  # for people
    unit: str = ""  # of what they are shown, "" if there is none
    scale: float = 1.0  # shown units per SI unit
    otherwise: float | None = 0.0  # SI, of a design that does not say; None: the robot's own

    @property
    def heading(self) -> str:
        """Title and unit."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title


_DEGREES = 180.0 / math.pi
_AXES = {
    axis.name: axis
    for axis in (
        Axis("twist", "Twist", "deg", _DEGREES),
        Axis("forward", "Forward", "m"),
        Axis("lateral", "Lateral", "m"),
        Axis("height", "Landing height", "m"),
        Axis("roll", "Roll", "deg", _DEGREES),
        Axis("pitch", "Pitch", "deg", _DEGREES),
        Axis("speed", "Speed", "m/s"),
        Axis("end_speed", "End speed", "m/s"),
        Axis("hops", "Hops", otherwise=1.0),
        Axis("drive_torque", "Torque of the drives", "%", 100.0, 1.0),
        Axis("drive_speed", "Speed of the drives", "%", 100.0, 1.0),
    )
}


def axis_of(name: str) -> Axis:
    """The axis of a column."""
    if name in _AXES:
        return _AXES[name]
    title = name.removeprefix(LIMIT).replace("_", " ").capitalize()
    return Axis(name, f"Limit: {title.lower()}", "SI", otherwise=None)


@dataclass(frozen=True, eq=False)
class Jumps:
    """Jumps of one robot, model and type."""

    robot: str  # of all of them
    model: str  # of all of them
    type: str  # of all of them
    numbers: IntArray  # (J,) in the sweep
    requested: Mapping[str, Array]  # axis name -> (J,) SI; limits begin with "limit_"
    planned: Array  # (J,) 0 or 1: there is a plan
    landed: Array  # (J,) share of the simulated seeds; NaN where nothing was simulated
    strict: Array  # (J,) share of the simulated seeds; NaN where nothing was simulated
    flight: Array  # (J,) s
    torque_share: Array  # (J,); NaN where there is no plan
    stops: tuple[str, ...]  # names of limiting constraints
    stop: IntArray  # (J,) places therein
    robot_hash: str  # of the robot's files
    arms: str = Jump.arms  # of all of them

    def __len__(self) -> int:
        return len(self.numbers)

    @property
    def axes(self) -> tuple[Axis, ...]:
        """Axes that vary among them, in the table's order."""
        return tuple(axis_of(name) for name, values in self.requested.items() if np.ptp(values) > 0)

    @property
    def simulated(self) -> bool:
        """True if any of them was."""
        return bool(np.isfinite(self.strict).any())

    def request(self, index: int) -> tuple[Jump, dict[str, float], dict[str, float]]:
        """A jump's request, its limits and its drives (times the robot file's)."""
        values = {name: float(column[index]) for name, column in self.requested.items()}
        amounts: dict[str, Any] = {name: values[name] for name in AMOUNTS}
        amounts["hops"] = int(amounts["hops"])
        limits = {
            name.removeprefix(LIMIT): value
            for name, value in values.items()
            if name.startswith(LIMIT) and math.isfinite(value)
        }
        drives = {name: values[name] for name in DRIVES if values[name] != 1.0}
        jump = Jump(robot=self.robot, model=self.model, type=self.type, arms=self.arms, **amounts)
        return jump, limits, drives


@dataclass(frozen=True, eq=False)
class Atlas:
    """A sweep's jumps."""

    title: str  # of the sweep
    groups: tuple[Jumps, ...]  # jumps of the same robot, model and type, as the sweep has them

    @property
    def robots(self) -> tuple[str, ...]:
        """Names or paths, as the sweep has them."""
        return tuple(dict.fromkeys(group.robot for group in self.groups))

    def jumps_of(self, robot: str, model: str = "", kind: str = "") -> Jumps | None:
        """Jumps of a robot, of this model and type if there are any, else of the first ones."""
        groups = [group for group in self.groups if group.robot == robot]
        return max(groups, key=lambda g: (g.type == kind, g.model == model), default=None)

    def find(self, number: int) -> tuple[Jumps, int] | None:
        """The jump with that number in the sweep: its group, and its place there."""
        for group in self.groups:
            place = int(np.searchsorted(group.numbers, number))
            if place < len(group) and group.numbers[place] == number:
                return group, place
        return None


def words_of(stop: str) -> str:
    """The name of a limiting constraint as the page shows it."""
    return {NOTHING: "none (feasible)", NOT_PLANNED: "no plan found"}.get(
        stop, stop.replace("_", " ")
    )
