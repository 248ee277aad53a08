"""Rows of the apex, against the CoM of a motion beside."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

import llsrbm
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.planning.whole_body.refine import refined
from llsrbm.planning.whole_body.start import start_of
from llsrbm.planning.whole_body.tops import KEPT, MISSED, tops
from llsrbm.robots import load_robot

JUMP = llsrbm.Jump(robot="go2", forward=0.3, twist=0.4)


def highest(plan):
    """Of the CoM, m, by its free fall from the knot that is nearest."""
    z, v = plan.com[:, 2], plan.com_velocity[:, 2]
    return float((z + v**2 / 19.62)[z.argmax()])


@pytest.fixture(scope="module")
def plan():
    return llsrbm.plan(JUMP, draft=True)


def test_they_say_how_far_the_highest_place_is_from_the_limits(plan):
    robot, rng = load_robot("go2"), np.random.default_rng(0)
    grid = Grid.of(plan)
    start = start_of(plan, robot, grid)
    assert tops(np.zeros((0, 0)), grid, start.task, robot) == {}
    state = [np.repeat(start.state[n], 2, axis=0)[: len(start.time)] for n in start.state]
    q = np.hstack([state[0], np.roll(state[1], -1, axis=1), state[2]])
    low, high = 0.2, 0.7
    ((top, rows),) = tops(q, grid, replace(start.task, apex=(low, high)), robot).items()
    data = robot.model.createData()
    z = [pin.centerOfMass(robot.model, data, each)[2] for each in q]
    assert z[top] == max(z)
    assert plan.lift_off < start.time[top] < plan.touchdown
    assert [row.room - MISSED for row in rows] == pytest.approx([z[top] - low, high - z[top]])
    assert {row.kept for row in rows} == {KEPT + MISSED}
    step = 1e-5 * rng.normal(size=robot.model.nv)
    there = pin.integrate(robot.model, q[top], step)
    moved = np.concatenate([there[:3] - q[top, :3], step[3:]])
    rise = pin.centerOfMass(robot.model, data, there)[2] - z[top]
    for row, sign in zip(rows, (1, -1), strict=True):
        assert row.slope @ moved == pytest.approx(sign * rise, abs=1e-8)


@pytest.mark.nightly
def test_draft_and_whole_bodys_plan_fly_as_high_as_was_asked(plan):
    wanted = highest(plan) + 0.05
    limits = {"apex_min": wanted - 1.5e-3, "apex_max": wanted + 1.5e-3}
    draft = llsrbm.plan(JUMP, limits=limits, draft=True)
    whole = refined(draft)
    assert whole.refined
    assert highest(draft) == pytest.approx(wanted, abs=3e-3)
    assert highest(whole) == pytest.approx(wanted, abs=4e-3)
