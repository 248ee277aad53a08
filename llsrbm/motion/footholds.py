"""Where a plan's feet stand: the knot at which each place of the schedule has each foot."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from llsrbm.motion.plan import Plan


def foothold_knots(plan: Plan) -> NDArray[np.int64]:
    """(K + 1, L) knots at which `foot_position` and `contact_point` hold the footholds of places.

    Place 0 is read where the plan starts, the others where their feet have stood longest, which is
    where the plan ends for the last. -1 where a foot never stands in a place.
    """
    schedule = plan.schedule
    ends = np.searchsorted(plan.time, plan.phase_start[1:] - 1e-9)
    knots = np.full((schedule.places + 1, len(schedule.legs)), -1, dtype=np.int64)
    for phase, end in zip(schedule, ends, strict=True):
        stands = [leg in phase.feet for leg in schedule.legs]
        knots[phase.place, stands] = 0 if phase.place == 0 else end
    return knots
