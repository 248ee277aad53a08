"""How far the sliders reach: the usual requests of a robot's file, and beyond what was asked for or
found.
"""

import math
from collections.abc import Mapping

from llsrbm.request.jump import STEPS, Jump
from llsrbm.robots.schema import Task

Beyond = Mapping[str, tuple[float, float]]
"""Field of a request -> least and most that goes beyond the usual, SI."""

_SLACK = 1e-6  # of a step: 0.3 / 0.01 is 29.999999999999996


def stretched(usual: Task, beyond: Beyond) -> Task:
    """The usual ends, moved outwards."""
    ends = {name: (*getattr(usual, name), *values) for name, values in beyond.items()}
    return usual.model_copy(update={name: (min(v), max(v)) for name, v in ends.items()})


def reaching(beyond: Beyond, usual: Task, jump: Jump) -> Beyond:
    """With what of a jump is beyond these ends and the usual ones, in whole steps."""
    grown = {**beyond}
    for name, step in STEPS.items():
        steps = getattr(jump, name) / step
        low, high = math.floor(steps + _SLACK) * step, math.ceil(steps - _SLACK) * step
        least, most = getattr(stretched(usual, beyond), name)
        if low < least - _SLACK * step or high > most + _SLACK * step:
            values = (low, high, *beyond.get(name, ()))
            grown[name] = round(min(values), 9), round(max(values), 9)
    return grown
