"""Limits that a request asks for: kept by the whole body's rows, or what is beyond them is said."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import llsrbm
from llsrbm.installed import assets_directory
from llsrbm.motion.realised import realised
from llsrbm.planning.whole_body.bounds import RowBounds
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.planning.whole_body.requested_limits import limit_violations
from llsrbm.planning.whole_body.sizes import Sizes
from llsrbm.planning.whole_body.start import start_of
from llsrbm.request.tuning import Tuning
from llsrbm.robots import load_robot

ROBOT = load_robot("go2")


@cache
def shipped():
    return llsrbm.load(assets_directory() / "plans" / "go2.npz")


def asking(**limits):
    """The shipped plan as if its request had asked for limits, and its start."""
    plan = shipped()
    plan = replace(plan, tuning=Tuning(limits=limits), limits={**plan.limits, **limits})
    return plan, start_of(plan, ROBOT, Grid.under(plan))


@pytest.mark.parametrize(("margin", "kept"), [(0.1, 0.1), (0.0, 0.01), (0.02, 0.01)])
def test_joints_keep_the_margin_that_is_asked_for(margin, kept):
    plan, start = asking(stop_margin=margin)
    grid = Grid.under(plan)
    rows = RowBounds(ROBOT, grid, Sizes.of(ROBOT, len(grid.phases)), start)
    stops = [(low, high) for name, _, _, low, high in rows if name == "stop"]
    assert stops
    for low, high in stops:
        np.testing.assert_allclose([low, high], ROBOT.stops_kept_by(kept))


def test_what_is_beyond_a_limit_is_measured():
    plan, start = asking(foot_speed=1.0, reach_max=0.3, feet_apart=0.3)
    found = limit_violations(plan, start.task, ROBOT)
    assert set(found) == {"foot_speed", "reach", "feet_apart"}
    time = np.linspace(plan.lift_off, plan.touchdown, 2000)
    moving = realised(plan, ROBOT, time)
    across = np.linalg.norm(np.gradient(moving.foot_position, time, axis=0), axis=-1)
    assert 0.5 < found["foot_speed"].amount < across.max()
    longest = np.linalg.norm(plan.foot_in_hip[1:-1], axis=-1).max()
    assert found["reach"].amount == pytest.approx(longest - 0.3)
    pairs = [(i, j) for i in range(4) for j in range(i)]
    flying = plan.foot_position[(plan.time >= plan.lift_off) & (plan.time < plan.touchdown)]
    nearest = min(
        np.linalg.norm(flying[:, i, :2] - flying[:, j, :2], axis=-1).min() for i, j in pairs
    )
    assert found["feet_apart"].amount == pytest.approx(max(0.3 - nearest, 0.0), abs=0.01)


def test_nothing_is_said_where_nothing_was_asked():
    plan, start = asking()
    assert limit_violations(plan, start.task, ROBOT) == {}


def test_a_plan_states_what_is_beyond():
    jump = llsrbm.Jump(robot="go2", forward=0.3, twist=1.0)
    plan = llsrbm.plan(jump, limits={"reach_x_min": -0.1, "reach_x_max": 0.1})
    x = plan.foot_in_hip[1:-1, :, 0]
    beyond = max(x.max() - 0.1, -0.1 - x.min())
    assert plan.violations["reach"].amount == pytest.approx(beyond)
    assert beyond > 1e-3
