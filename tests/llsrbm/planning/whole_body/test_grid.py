"""Knots' instants, and the grid that a plan is of."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from llsrbm.planning.whole_body.grid import DENSER_IN_FLIGHT, Grid
from tests.llsrbm.player.stages import stored_plan

PLAN = stored_plan()


@settings(max_examples=20)
@given(dense=st.floats(0.0, 1.0))
def test_the_density_of_a_flight_is_read_from_a_plans_knots(dense):
    grid = replace(Grid.of(PLAN), denser_in_flight=dense)
    found = Grid.under(replace(PLAN, time=grid.times(PLAN.phase_start)))
    assert found.phases == grid.phases
    assert found.denser_in_flight == pytest.approx(dense, abs=1e-8)


def test_a_new_plan_is_as_dense_as_the_problem_is_today():
    assert Grid.under(PLAN) == Grid.of(PLAN)
    assert Grid.under(PLAN).denser_in_flight == DENSER_IN_FLIGHT


def test_the_rest_of_a_plan_after_its_flight_has_none_to_read():
    rest = replace(PLAN.schedule, phases=PLAN.schedule.phases[-1:], under_way=True)
    on = PLAN.phase == len(PLAN.schedule) - 1
    landed = replace(
        PLAN,
        time=PLAN.time[on],
        phase=np.zeros(on.sum(), dtype=np.int64),
        schedule=rest,
    )
    assert Grid.under(landed).denser_in_flight == DENSER_IN_FLIGHT


def test_intervals_are_shorter_beside_lift_off_and_touchdown_than_between():
    grid = Grid.of(PLAN)
    times = grid.times(PLAN.phase_start)[::2]
    (flight,) = (number for number, (legs, _) in enumerate(grid.phases) if not legs)
    lift_off, touchdown = PLAN.phase_start[flight : flight + 2]
    steps = np.diff(times[(times >= lift_off - 1e-9) & (times <= touchdown + 1e-9)])
    middle = len(steps) // 2
    assert steps[0] < steps[middle] > steps[-1]
