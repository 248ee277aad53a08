"""A tier without a robot: its first commands, and its code run once before it has to be fast."""

from __future__ import annotations

import numpy as np

from llsrbm.control.motor_command import MotorCommand
from llsrbm.control.readings import Readings
from llsrbm.mechanics import GRAVITY
from llsrbm.motion.plan import Plan
from llsrbm.player.tier import PERIOD, Tier
from llsrbm.player.tiers import make_tier
from llsrbm.robots import Robot

_STANDS = 0.02  # s before the start
_APART = 0.02  # s between the instants of the plan that are tried


def first_commands(
    tier: str, plan: Plan, robot: Robot, count: int
) -> list[tuple[float, MotorCommand]]:
    """The first commands of a plan, with their times, s, for a robot that stands still meanwhile.

    Raises `InputError`: no such tier, or the robot cannot stand as the plan begins.
    """
    made = make_tier(tier, plan, robot)
    times = PERIOD * np.arange(-round(_STANDS / PERIOD), count)
    commands = [(t, made.command(t, _at_rest(made, t))) for t in times.tolist()]
    return commands[-count:]


def rehearse(tier: str, plan: Plan, robot: Robot) -> None:
    """Run a tier through its plan, as if the robot stood still; nothing of it is kept.

    The first call of each part takes ten times as long as the next. Raises as `first_commands`.
    """
    made = make_tier(tier, plan, robot)
    for time in np.arange(-_STANDS, made.end, _APART).tolist():
        made.command(time, _at_rest(made, time))


def _at_rest(tier: Tier, time: float) -> Readings:
    """Readings of a robot that stands as the plan begins."""
    q = tier.first.q
    still = np.zeros(len(q) - 7)
    up = tier.first.planned.up
    return Readings(
        time, q[[6, 3, 4, 5]], np.zeros(3), GRAVITY * up, q[7:], still, tier.first.torque, None
    )
