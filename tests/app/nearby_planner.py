"""A planner of whose jumps one cannot be planned, but another near it can."""

from __future__ import annotations

import math
from dataclasses import replace

from tests.app.planners import UNSOLVABLE, Nearest, SyntheticPlanner, is_
from tests.app.synthetic_plan import synthetic_plan

NEAR = math.radians(50)


class NearbyPlanner(SyntheticPlanner):
    """Finds 50 degrees where 55 cannot be planned."""

    def nearest(self, task, progress, cancelled):
        assert is_(task.jump, UNSOLVABLE)
        jump = replace(task.jump, twist=NEAR)
        return Nearest(jump, synthetic_plan(jump), "twist 50 deg instead of 55")
