"""Planners for the process under test; twist, or seed, says how they shall behave."""

from __future__ import annotations

import math
import os
import time
from dataclasses import replace

from llsrbm import errors
from llsrbm.errors import InputError
from llsrbm.jump import Jump
from tests.app.synthetic_plan import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout

SLOW = math.radians(51)  # works one second, asks whether to stop
STUBBORN = math.radians(52)  # works for a minute and never asks
CRASH = math.radians(53)  # the process dies
DEFECT = math.radians(54)  # an exception that is no llsrbm.Error
UNSOLVABLE = math.radians(55)  # NotConverged with a plan
REFUSED = math.radians(56)  # InputError

# Seeds of simulations:
SLOWLY = 51  # takes five seconds, asks whether to stop
STUBBORNLY = 52  # takes a minute and never asks
FALLING = 53  # the robot falls
IMPOSSIBLE = 54  # InputError
TRIPPING = 55  # the robot falls before it has left the ground


class SyntheticPlanner:
    def prepare(self, robot, progress):
        progress(f"preparing {robot}")
        if robot == "nosuch":
            raise InputError('no robot "nosuch"')

    def plan(self, jump: Jump, progress, cancelled):
        progress("solving")
        if math.isclose(jump.twist, SLOW):
            for _ in range(100):
                time.sleep(0.01)
                if cancelled():
                    raise errors.Cancelled("stopped")
        elif math.isclose(jump.twist, STUBBORN):
            time.sleep(60)
        elif math.isclose(jump.twist, CRASH):
            os._exit(9)
        elif math.isclose(jump.twist, DEFECT):
            raise ZeroDivisionError("a defect")
        elif math.isclose(jump.twist, UNSOLVABLE):
            raise errors.NotConverged(
                "no convergence: reach violated in flight by 0.02 m",
                synthetic_plan(jump, "not-converged"),
            )
        elif math.isclose(jump.twist, REFUSED):
            raise InputError("twist: expected -1 to 1 rad, got more")
        return synthetic_plan(jump)

    def simulate(self, plan, conditions, progress, cancelled):
        progress(0.0)
        if conditions.seed == SLOWLY:
            for i in range(500):
                time.sleep(0.01)
                progress(i / 500)
                if cancelled():
                    raise errors.Cancelled("stopped")
        elif conditions.seed == STUBBORNLY:
            progress(0.01)
            time.sleep(60)
        elif conditions.seed == IMPOSSIBLE:
            raise InputError("board: expected 0 to 0.05 m, got more")
        progress(1.0)
        fell_at = {FALLING: 1.1, TRIPPING: 0.2}.get(conditions.seed)
        rollout = synthetic_rollout(plan, fell_at=fell_at, seed=conditions.seed)
        return replace(rollout, conditions=conditions)


def broken_factory():
    raise ModuleNotFoundError("no planner here")
