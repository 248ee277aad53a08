"""Changes of the planner by a request: weights of costs, limits of constraints."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from llsrbm.errors import InputError
from llsrbm.request.messages import Number


@dataclass(frozen=True)
class Tuning:
    """Values in place of a robot's own; what is not named stays as the robot has it.

    Raises:
        InputError: a value that is no finite number. Whether the names exist and the values are in
            range depends on the robot, and is said when something is planned.
    """

    # Cost name -> weight (`llsrbm.planning.problem.costs`).
    weights: Mapping[str, float] = field(default_factory=dict)
    # Limit name -> value in its SI unit (`llsrbm.planning.problem.limits`).
    limits: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for kind in ("weights", "limits"):
            given: Any = getattr(self, kind)
            if not isinstance(given, Mapping):
                raise InputError(
                    f"Tuning.{kind}: expected names with numbers, got {type(given).__name__}"
                )
            values = {name: _number(kind, name, value) for name, value in given.items()}
            object.__setattr__(self, kind, values)

    def __bool__(self) -> bool:
        """True if anything is changed."""
        return bool(self.weights or self.limits)

    def __hash__(self) -> int:
        return hash((frozenset(self.weights.items()), frozenset(self.limits.items())))


def _number(kind: str, name: Any, value: Any) -> float:
    if not isinstance(name, str):
        raise InputError(f"Tuning.{kind}: expected names as text, got {name!r}")
    return Number("").checked(f"Tuning.{kind}.{name}", value)
