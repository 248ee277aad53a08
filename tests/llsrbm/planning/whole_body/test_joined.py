"""Rows of jumps, begun from plans of each by itself."""

from functools import cache

import numpy as np
import pytest

import llsrbm
from llsrbm.mechanics import rotation_matrices, yaw
from llsrbm.planning.problem.placement import make_task, retargeted
from llsrbm.planning.whole_body.joined import joined
from llsrbm.planning.whole_body.unplanned import unplanned
from llsrbm.robots import load_robot
from tests.llsrbm.kinematics import foot_positions

ROBOT = load_robot("go2")
ROUTE = llsrbm.Jump(
    robot="go2",
    route=[{"forward": 0.2, "twist": 0.5}, {"forward": 0.15, "lateral": 0.05, "height": 0.05}],
)
SAME = 2e-3  # m


@cache
def row():
    """A task, and plans of its jumps one after the other."""
    task = make_task(ROUTE, ROBOT)
    parts = [llsrbm.plan(retargeted(task, one).jump) for one in ROUTE.singly(ROUTE.route)]
    return task, parts, joined(task, unplanned(task, ROBOT, "fatrop"), parts)


def test_it_is_a_plan_of_the_row():
    task, parts, found = row()
    assert found.jump == ROUTE
    assert found.duration == pytest.approx(sum(part.duration for part in parts))
    assert (np.diff(found.time) > 0).all()
    assert set(np.diff(found.phase)) == {0, 1}
    assert found.phase[-1] == len(task.schedule) - 1


def test_feet_are_on_its_places_by_forward_kinematics():
    task, _, found = row()
    order = [found.joint_names.index(name) for name in ROBOT.joint_names]
    q = found.joint_position[:, order]
    feet = foot_positions(ROBOT, found.base_position, found.base_quat, q)
    for place, knot in ((0, 0), (2, -1)):
        np.testing.assert_allclose(feet[knot], task.places[place].feet, atol=SAME)
    assert yaw(found.base_quat[-1:])[0] == pytest.approx(0.5, abs=1e-3)


def test_momenta_are_of_its_axes():
    _, parts, found = row()
    knots = len(parts[0].time) - 1
    R = rotation_matrices(parts[0].base_quat[-1])
    np.testing.assert_allclose(
        found.linear_momentum[knots:], parts[1].linear_momentum @ R.T, atol=1e-2
    )


@pytest.mark.nightly
def test_it_is_planned_from_there_and_followed():
    plan = llsrbm.plan(ROUTE)
    assert plan.certified
    assert plan.report.attempts == 0
    assert llsrbm.simulate(plan, seed=3).outcome.strict
