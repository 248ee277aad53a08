"""A tier without a robot: its first commands, and its code run once before it has to be fast."""

import numpy as np

from llsrbm.control.motor_command import MotorCommand
from llsrbm.control.readings import Readings
from llsrbm.mechanics import GRAVITY
from llsrbm.player.tier import PERIOD, Tier

_STANDS = 0.02  # s before the start
_APART = 0.02  # s between the instants that are tried
_LONGEST = 10.0  # s; what comes later is more of the same


def first_commands(made: Tier, count: int) -> list[tuple[float, MotorCommand]]:
    """The first commands of a fresh tier, with their times, s, for a robot that stays still."""
    times = PERIOD * np.arange(-round(_STANDS / PERIOD), count)
    commands = [(t, made.command(t, _at_rest(made, t))) for t in times.tolist()]
    return commands[-count:]


def rehearse(made: Tier) -> None:
    """Run a tier that is not used afterwards, as if the robot stayed still.

    The first call of each part takes ten times as long as the next.
    """
    for time in np.arange(-_STANDS, min(made.end, _LONGEST), _APART).tolist():
        made.command(time, _at_rest(made, time))


def _at_rest(tier: Tier, time: float) -> Readings:
    """Readings of a robot that is at rest as it begins."""
    q = tier.first.q
    still = np.zeros(len(q) - 7)
    up = tier.first.planned.up
    return Readings(
        time, q[[6, 3, 4, 5]], np.zeros(3), GRAVITY * up, q[7:], still, tier.first.torque, None
    )
