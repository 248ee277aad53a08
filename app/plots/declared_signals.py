"""The signals that plans and rollouts declare in the table of quantities; none is named twice."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from app.plots.course import Course, recorded_name
from app.plots.signal import Component, Samples, Signal, joint_tags
from llsrbm.files.quantity import (
    CONTACT,
    JOINT,
    LEG,
    TENSOR,
    TIME,
    WXYZ,
    XYZ,
    Kind,
    Quantity,
    derived,
    quantities,
)
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout

_TENSOR = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
_PARTS = {XYZ: "xyz", WXYZ: "wxyz"}
_WORDS = {"com": "CoM", "quat": "quaternion", "reference": "tracked:"}

# In view at least; a still robot's noise shall not fill a chart.
_LEAST = {
    "angular_velocity": 0.2,
    "com_velocity": 0.1,
    "base_velocity": 0.1,
    "linear_momentum": 2.0,
    "angular_momentum": 0.2,
    "joint_velocity": 0.2,
}


def declared_signals() -> Iterator[Signal]:
    """A signal for each quantity over time that files list; those of the feet's forces are one."""
    found: dict[str, Quantity] = {}
    for of in (Plan, Rollout):
        for name, quantity in (quantities(of) | derived(of)).items():
            over_time = quantity.axes[:1] == (TIME,) and quantity.axes != (TIME,)
            scalar = quantity.axes == (TIME,) and name != "time"
            if quantity.listed and quantity.kind is not Kind.TEXT and (over_time or scalar):
                found.setdefault(_key(of, name), quantity)
    for key, quantity in found.items():
        yield Signal(
            key,
            _title(key),
            quantity.meaning,
            _tabled(key, quantity),
            _LEAST.get(key, 0.0),
        )


def _title(key: str) -> str:
    """Such as "Foot position"; the CoM's own quantity is its position."""
    words = f"{key}_position" if key.endswith("com") else key
    title = " ".join(_WORDS.get(word, word) for word in words.split("_"))
    return title[:1].upper() + title[1:]


def _key(of: type, name: str) -> str:
    # A plan's forces are those of contacts, of which a sole has four; a rollout's those of feet.
    if of is Rollout and name == "contact_force":
        return "foot_force"
    return recorded_name(name) if of is Rollout else name


def _tabled(key: str, quantity: Quantity) -> Callable[[Course], Samples | None]:
    def samples(course: Course) -> Samples | None:
        values = course.quantity(key)
        if values is None:
            return None
        if quantity.axes[-1] == TENSOR:
            values = np.stack([values[:, i, j] for i, j in _TENSOR.values()], axis=1)
        values = values.reshape(len(values), -1)
        return Samples(course.time, tuple(_components(course, quantity, values.shape[1])), values)

    return samples


def _components(course: Course, quantity: Quantity, count: int) -> Iterator[Component]:
    unit = _written(quantity.unit) or ", ".join(f"{i} {c}" for i, c in enumerate(quantity.codes))
    axes = quantity.axes[1:]
    if not axes:
        yield Component("", unit)
    elif axes == (JOINT,):
        sliding = course.robot.sliding_joints
        for name, tags in joint_tags(course.robot).items():
            yield Component(name, quantity.unit_of(name, sliding), tags)
    elif axes[0] in (LEG, CONTACT):
        parts = _PARTS.get(axes[1], "") if len(axes) > 1 else ""
        places = count // max(1, len(parts))
        corners = places // len(course.leg_names)
        for place in range(places):
            leg = course.leg_names[place // corners]
            name = leg if corners == 1 else f"{leg} {place % corners + 1}"
            for part in parts or ("",):
                yield Component(f"{name} {part}".strip(), unit, (leg, part) if part else (leg,))
    else:
        for part in _TENSOR if axes == (TENSOR,) else _PARTS[axes[0]]:
            yield Component(part, unit)


def _written(unit: str) -> str:
    return unit.replace("m2", "m²")
