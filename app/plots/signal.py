"""Signals, which can be plotted of a motion over time: one, its components, and samples of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.plots.choice import ALL_JOINTS
from app.plots.course import Course
from llsrbm.robots import Robot

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Component:
    """One number of a quantity.

    Attributes:
        name: "x", "LF z", a joint's; "" of a quantity that is one number.
        unit: SI, or degrees.
        tags: names of sets that it belongs to, besides its own: "LF", "z", a kind of joints.
    """

    name: str
    unit: str
    tags: tuple[str, ...] = ()

    def is_one_of(self, names: tuple[str, ...]) -> bool:
        """Whether it is named, or one of its tags is; true if nothing is named."""
        return not names or self.name in names or not set(self.tags).isdisjoint(names)


@dataclass(frozen=True, eq=False)
class Samples:
    """A signal of one motion.

    Attributes:
        time: (K,) s, increasing.
        components: n of them.
        values: (K, n).
    """

    time: Array
    components: tuple[Component, ...]
    values: Array


@dataclass(frozen=True)
class Level:
    """A dashed line across a chart.

    Attributes:
        title: in the legend.
        of: its value for one motion, or None.
    """

    title: str
    of: Callable[[Course], float | None]


@dataclass(frozen=True)
class Signal:
    """One quantity of motions over time.

    Attributes:
        key: by which choices name it.
        title: in menus and above charts.
        meaning: a phrase for people.
        of: samples of a motion, or None if it has no such thing.
        least: values from -least to least are in view, however small what is drawn: a tenth of a
            degree shall not look like a fall. 0: nothing but what is drawn.
        most: values beyond ±most are drawn there; files have them as they are.
        level: a limit or threshold.
        also: a second curve of plans that are not pinned, drawn dashed; `also_title` is its name.
    """

    key: str
    title: str
    meaning: str
    of: Callable[[Course], Samples | None]
    least: float = 0.0
    most: float = np.inf
    level: Level | None = None
    also: Callable[[Course], Samples] | None = None
    also_title: str = ""


def joint_kinds(robot: Robot) -> tuple[str, ...]:
    """Sets of a robot's joints: all of them, and those at one place of its legs."""
    kinds = [_kind(leg.name, joint) for leg in robot.legs for joint in leg.joints]
    return (ALL_JOINTS, *dict.fromkeys(kinds))


def _kind(leg: str, joint: str) -> str:
    return joint.removeprefix(leg).strip("_").removesuffix("_joint")


def joint_tags(robot: Robot) -> dict[str, tuple[str, ...]]:
    """Joint, in the robot's order -> its kind and its leg."""
    tags = {joint: (_kind(leg.name, joint), leg.name) for leg in robot.legs for joint in leg.joints}
    return {name: tags.get(name, ()) for name in robot.joint_names}
