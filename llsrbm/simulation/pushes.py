"""Pushes in a simulation: those that are stated, and one that the seed draws."""

from __future__ import annotations

import math

import numpy as np

from llsrbm.errors import InputError
from llsrbm.motion.plan import Plan
from llsrbm.request.push import DURATION, Push
from llsrbm.request.scenario import Scenario
from llsrbm.simulation.episode import Hook, Situation


class Pushes(Hook):
    """Pushes the world as a scenario asks; a push's impulse is exact whatever the tick.

    Attributes:
        drawn: the random push, if one is asked for.
    """

    def __init__(self, plan: Plan, scenario: Scenario, duration: float) -> None:
        """Collect a scenario's pushes.

        Args:
            plan: what is followed.
            scenario: the stated pushes, the random one's size, and its seed.
            duration: s that are simulated.

        Raises:
            InputError: a push outside of the simulated time.
        """
        self.drawn = drawn_push(plan, scenario)
        self._pushes = (*scenario.pushes, *(() if self.drawn is None else (self.drawn,)))
        latest = duration - DURATION
        for push in self._pushes:
            if push.time > latest:
                raise InputError(
                    f"push: time: expected 0 to {latest:.2f} s, as the simulation ends at "
                    f"{duration:.2f} s, got {push.time:g} s"
                )

    def before(self, situation: Situation) -> None:
        """Act with what of each push falls into the tick."""
        start, tick = situation.time, situation.world.tick
        for push in self._pushes:
            overlap = min(start + tick, push.time + DURATION) - max(start, push.time)
            if overlap > 0:
                share = overlap / DURATION / tick
                situation.world.push(share * np.array(push.impulse), share * np.array(push.moment))


def drawn_push(plan: Plan, scenario: Scenario) -> Push | None:
    """The push that a scenario's seed draws, the same direction and moment whatever its size.

    Horizontal in any direction, at any moment from the plan's start to its last touchdown.
    """
    if scenario.random_push is None:
        return None
    rng = np.random.default_rng([scenario.seed or 0, 2])  # apart from disturbance and noise
    angle, moment = rng.uniform(0.0, 2 * math.pi), rng.uniform(0.0, plan.touchdown)
    size = scenario.random_push
    return Push(moment, (size * math.cos(angle), size * math.sin(angle), 0.0))
