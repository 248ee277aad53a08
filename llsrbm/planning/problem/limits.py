"""The limits that a request may change, generated from what the constraints declare."""

from collections.abc import Mapping
from dataclasses import replace

from llsrbm.errors import InputError
from llsrbm.planning.problem.constraints import CONSTRAINTS
from llsrbm.planning.problem.limit_table import Limit
from llsrbm.planning.problem.task import Task

__all__ = ["Limit", "check_limits", "limit_unit", "limits_in", "put_limits"]

_LIMITS = {limit.name: limit for constraint in CONSTRAINTS for limit in constraint.limits}

# What the upper of two limits, name_max, stays above the lower, name_min: an interior-point solver
# needs an interior. In the limits' own unit: 1 mm, 1 ms.
_ROOM = 1e-3


def limit_unit(name: str) -> str | None:
    """The unit of the limit called `name`; None: there is no such limit."""
    return _LIMITS[name].unit if name in _LIMITS else None


def limits_in(task: Task) -> dict[str, tuple[Limit, float]]:
    """Limit name -> the limit and its value; `lowest` and `highest` in its unit.

    Of a task that changes no limits these are the robot's own values.
    """
    found = {}
    for limit in (x for c in CONSTRAINTS if c.concerns(task) for x in c.limits):
        value = limit.of(task)
        scale = value if limit.relative else 1.0
        ends = [float(f"{end * scale:.3g}") + 0.0 for end in (limit.lowest, limit.highest)]
        # A robot file may say what is out of the usual range; it is accepted then.
        low, high = min(*ends, value), max(*ends, value)
        found[limit.name] = (replace(limit, lowest=low, highest=high, relative=False), value)
    return found


def check_limits(given: Mapping[str, float], task: Task, robot: str) -> None:
    """Refuse limits that do not exist or cannot be.

    Args:
        given: limit name -> value.
        task: one that changes no limits.
        robot: its name, for messages.

    Raises:
        InputError: an unknown name, a value out of range, or a shortest above a longest.
    """
    known = limits_in(task)
    for name, value in given.items():
        if name not in known:
            raise InputError(
                f"unknown limit {name!r}; the limits of {robot} are {', '.join(known)}"
            )
        limit = known[name][0]
        if not limit.lowest <= value <= limit.highest:
            unit = "" if limit.unit == "1" else f" {limit.unit}"
            raise InputError(
                f"limit {name}: {value:g}{unit} is out of range; {robot} takes "
                f"{limit.lowest:.4g} to {limit.highest:.4g}{unit}"
            )
    for name in given:
        stem = name.removesuffix("_min").removesuffix("_max")
        pair = (f"{stem}_min", f"{stem}_max")
        if stem == name or not set(pair) <= set(known):
            continue
        low, high = (given.get(end, known[end][1]) for end in pair)
        if high - low < _ROOM:
            unit = known[name][0].unit
            raise InputError(
                f"limit {name}: {pair[0]} {low:g} {unit} and {pair[1]} {high:g} {unit} leave no "
                f"room between them; expected {pair[1]} to be at least {_ROOM:g} {unit} more"
            )


def put_limits(task: Task, given: Mapping[str, float]) -> Task:
    """The task under other limits, which have been checked."""
    for name, value in given.items():
        task = _LIMITS[name].put(task, value)
    return task
