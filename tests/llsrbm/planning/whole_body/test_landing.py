"""How a whole body comes down."""

import math

import numpy as np

import llsrbm
from llsrbm.certified_plan import CertifiedPlanner
from llsrbm.mechanics import tilt
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.robots import load_robot

FEET = (0, 1, 2, 3)


def test_what_stands_after_a_flight_has_landed():
    hops = Grid(((FEET, 2), ((), 3), (FEET, 2), ((), 3), ((2, 3), 2)))
    landed = hops.landed
    assert len(landed) == 2 * hops.intervals + 1
    phases = np.array([hops.phase_at(half) for half in range(len(landed))])
    assert [landed[phases == p].all() for p in range(5)] == [False, False, True, False, True]
    assert [landed[phases == p].any() for p in range(5)] == [False, False, True, False, True]


def test_the_trunk_comes_down_level():
    # Onto a box it leant by 11 degrees, and by 19 once it had landed in the simulator.
    jump = llsrbm.Jump("go2", twist=math.radians(-16), forward=0.41, lateral=-0.08, height=0.21)
    plan = CertifiedPlanner().from_table(make_task(jump, load_robot("go2")))
    assert plan is not None
    after = plan.time >= plan.touchdown - 1e-9
    assert np.degrees(tilt(plan.base_quat[after]).max()) < 6
