"""Planners for the process under test; the twist says how they shall behave."""

from __future__ import annotations

import math
import os
import time

from llsrbm import errors
from llsrbm.errors import InputError
from llsrbm.jump import Jump
from tests.app.synthetic_plan import synthetic_plan

SLOW = math.radians(51)  # works one second, asks whether to stop
STUBBORN = math.radians(52)  # works for a minute and never asks
CRASH = math.radians(53)  # the process dies
DEFECT = math.radians(54)  # an exception that is no llsrbm.Error
UNSOLVABLE = math.radians(55)  # NotConverged with a plan
REFUSED = math.radians(56)  # InputError


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


def broken_factory():
    raise ModuleNotFoundError("no planner here")
