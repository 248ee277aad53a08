"""Landing strategies: use of the plan's landing forces after touchdown."""

from collections.abc import Callable
from dataclasses import dataclass

from llsrbm.arrays import Array
from llsrbm.errors import InputError
from llsrbm.request.messages import look_up

_SCALES = (0.2, 1.5)  # beyond these the measured momentum says that something else is wrong


@dataclass(frozen=True)
class LandingStrategy:
    """One way to land."""

    description: str  # one line
    follows_forces: bool  # whether a force phase follows touchdown
    # (planned (C, 3) N, standing (C, 3) N, momentum met / planned) -> wanted (C, 3) N.
    force: Callable[[Array, Array, float], Array]


def _as_planned(planned: Array, _standing: Array, _share: float) -> Array:
    return planned


def _scaled(planned: Array, standing: Array, share: float) -> Array:
    least, most = _SCALES
    return standing + min(max(share, least), most) * (planned - standing)


AUTO = "auto"
_AUTO = (
    "scaled where the robot file has a force phase, tracking where it has none and in flips, whose "
    "legs have little stroke left (the default)"
)
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
    """Name of each strategy -> one line, the default first."""
    return {AUTO: _AUTO} | {name: one.description for name, one in _STRATEGIES.items()}


def resolved(name: str, force_phase: float, *, turns: bool = False) -> str:
    """The strategy of a name, or of "auto" on a robot that follows forces for `force_phase`, s.

    `turns`: the body turns over. It lands deep, and forces that are followed do not see how deep.

    Raises `InputError`: no such strategy, or one that follows forces on a robot that never does.
    """
    look_up("landing strategy", name, names())
    if name == AUTO:
        return "scaled" if force_phase > 0 and not turns else "tracking"
    if _STRATEGIES[name].follows_forces and force_phase == 0:
        raise InputError(
            f'landing: "{name}" follows forces after touchdown, and the robot file has no force '
            f'phase (control.force_phase = 0); expected "{AUTO}" or "tracking", or a force phase '
            "in the file"
        )
    return name


def landing_strategy(name: str) -> LandingStrategy:
    """The strategy of a name that is `resolved`."""
    return _STRATEGIES[name]
