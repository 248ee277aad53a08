"""What a controller does with the plan's landing forces once it has met the ground."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from llsrbm.errors import InputError

Array = NDArray[np.float64]

_SCALES = (0.2, 1.5)  # beyond these the measured momentum says that something else is wrong


@dataclass(frozen=True)
class LandingStrategy:
    """One way to land.

    Attributes:
        description: one line.
        follows_forces: whether a force phase follows touchdown.
        force: (planned (C, 3) N, standing (3,) N a contact, momentum met / planned) -> wanted.
    """

    description: str
    follows_forces: bool
    force: Callable[[Array, Array, float], Array]


def _as_planned(planned: Array, _standing: Array, _share: float) -> Array:
    return planned


def _scaled(planned: Array, standing: Array, share: float) -> Array:
    """The part that brakes in proportion to the momentum that is there to be braked."""
    return standing + float(np.clip(share, *_SCALES)) * (planned - standing)


_STRATEGIES = {
    "scaled": LandingStrategy(
        "force phase with the plan's forces, scaled about the weight to the momentum met",
        follows_forces=True,
        force=_scaled,
    ),
    "planned": LandingStrategy(
        "force phase with the plan's forces as they are (the paper's)",
        follows_forces=True,
        force=_as_planned,
    ),
    "tracking": LandingStrategy(
        "no force phase: the plan's trajectory, retimed", follows_forces=False, force=_as_planned
    ),
}


def names() -> dict[str, str]:
    """Strategy -> one line."""
    return {name: strategy.description for name, strategy in _STRATEGIES.items()}


def landing_strategy(name: str) -> LandingStrategy:
    """The strategy of that name.

    Raises:
        InputError: no such strategy.
    """
    if name not in _STRATEGIES:
        raise InputError(f'landing: no strategy "{name}"; valid: {", ".join(_STRATEGIES)}')
    return _STRATEGIES[name]
