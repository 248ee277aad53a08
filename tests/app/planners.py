"""Planners for the process under test; the twist says how they shall behave."""

from __future__ import annotations

import os
import time

from llsrbm import errors
from llsrbm.errors import InputError
from llsrbm.jump import Jump
from tests.app.synthetic_plan import synthetic_plan

SLOW = 1.01  # works one second, asks whether to stop
STUBBORN = 1.02  # works for a minute and never asks
CRASH = 1.03  # the process dies
DEFECT = 1.04  # an exception that is no llsrbm.Error
UNSOLVABLE = 1.05  # NotConverged with a plan
REFUSED = 1.06  # InputError


class SyntheticPlanner:
    def prepare(self, robot, progress):
        progress(f"preparing {robot}")
        if robot == "nosuch":
            raise InputError('no robot "nosuch"')

    def plan(self, jump: Jump, progress, cancelled):
        progress("solving")
        if jump.twist == SLOW:
            for _ in range(100):
                time.sleep(0.01)
                if cancelled():
                    raise errors.Cancelled("stopped")
        elif jump.twist == STUBBORN:
            time.sleep(60)
        elif jump.twist == CRASH:
            os._exit(9)
        elif jump.twist == DEFECT:
            raise ZeroDivisionError("a defect")
        elif jump.twist == UNSOLVABLE:
            raise errors.NotConverged(
                "no convergence: reach violated in flight by 0.02 m",
                synthetic_plan(jump, "not-converged"),
            )
        elif jump.twist == REFUSED:
            raise InputError("twist: expected -1 to 1 rad, got 1.06")
        return synthetic_plan(jump)


def broken_factory():
    raise ModuleNotFoundError("no planner here")
