"""The surfaces that the feet of a plan stand on: how they slope."""

import numpy as np

from llsrbm.arrays import Array
from llsrbm.mechanics import yaw
from llsrbm.motion.plan import Plan
from llsrbm.motion.sampling import foothold_knots
from llsrbm.request.slopes import gradients, normals, slopes_of

_UP = np.array([0.0, 0.0, 1.0])


def place_headings(plan: Plan) -> list[float]:
    """Rad, of the robot that stands at the start and in each place after it."""
    if plan.schedule.places == 1:  # to the digit
        return [0.0, plan.jump.twist]
    base = [int(row.max()) for row in foothold_knots(plan)]
    return [0.0, *(float(angle) for angle in yaw(plan.base_quat)[base][1:])]


def foot_normals(plan: Plan, time: Array) -> Array:
    """(K, L, 3) unit normals of what each foot stands on at instants (K,) s.

    Of a foot in the air what it left over the first half of its swing, then what it lands on.
    """
    schedule = plan.schedule
    found = np.broadcast_to(_UP, (len(time), len(schedule.legs), 3)).copy()
    if not np.any(slopes_of(plan.jump, schedule.places)):
        return found
    of_place = normals(np.array(gradients(plan.jump, schedule.places, place_headings(plan))))
    edges = plan.phase_start
    phase = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, len(schedule) - 1)
    for leg in range(len(schedule.legs)):
        stands = schedule.stands[:, leg]
        for p in range(len(schedule)):
            here = phase == p
            before, after = schedule.places_before[p, leg], schedule.places_after[p, leg]
            lands = np.zeros(len(time), dtype=bool)
            if not stands[p]:
                there = np.flatnonzero(stands)
                lift, touch = edges[there[there < p][-1] + 1], edges[there[there > p][0]]
                lands = time > (lift + touch) / 2
            found[here & ~lands, leg] = of_place[before]
            found[here & lands, leg] = of_place[after]
    return found
