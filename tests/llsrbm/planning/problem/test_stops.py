"""Joints keep off their stops, in Go2's numbers; angles by Pinocchio."""

from dataclasses import replace

import numpy as np
import pytest

from llsrbm.planning.answer.planner import planner_of
from llsrbm.planning.problem.constraints import CONSTRAINTS
from llsrbm.planning.problem.constraints.stops import RESERVE, JointStops
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot

# A plan that knows no stops stretches a knee 0.34 rad beyond its own.
JUMP = Jump(robot="go2", twist=0.426, forward=0.402, lateral=0.062, height=0.058)
CONSTRAINT = next(c for c in CONSTRAINTS if isinstance(c, JointStops))


@pytest.fixture(scope="module")
def planner():
    return planner_of(JUMP)


@pytest.fixture(scope="module")
def planned(planner):
    return planner.plan(JUMP, patient=False), planner.last_knots()


def worst(plan):
    """Furthest beyond a stop at any knot, rad; below zero where there is room."""
    lower, upper = load_robot("go2").joint_stops
    return np.maximum(lower - plan.joint_position, plan.joint_position - upper).max()


def test_plans_keep_the_margin(planner, planned):
    plan, _ = planned
    assert plan.violations["joint_stops"].amount == 0.0
    assert worst(plan) < -0.01
    further = planner.plan(JUMP, limits={"stop_margin": 0.05}, patient=False)
    assert worst(further) < worst(plan) - 0.03


def test_without_rows_this_jump_would_break_a_stop(planner, monkeypatch):
    def everything(self, task, layout, knot):
        far = np.full(len(task.stopped_joints), 100.0)
        return -far, far

    monkeypatch.setattr(JointStops, "bounds", everything)
    monkeypatch.setattr(JointStops, "checked", lambda self, task: False)
    assert worst(planner.plan(JUMP, patient=False)) > 0.05


def test_bounds_follow_the_whole_body(planned):
    """Rows at the bound, with as much between them and Pinocchio's angles as here."""
    _, knots = planned
    bounds, robot = CONSTRAINT.agreed_bounds(knots), knots.task.robot
    joints, lower, upper = knots.task.stopped_joints, *robot.joint_stops
    rows = knots.rows[CONSTRAINT]
    at = np.unique(rows.knot)
    gap = knots.postures.joint_position[at][:, joints] - rows.values.reshape(len(at), -1)
    room = (upper - lower)[joints]
    assert np.abs(gap).max() < 0.05
    assert (bounds.upper[at][:, joints] + gap <= upper[joints] - RESERVE * room + 1e-9).all()
    assert (bounds.lower[at][:, joints] + gap >= lower[joints] + RESERVE * room - 1e-9).all()


def test_a_joint_beyond_its_stop_is_named(planned):
    _, knots = planned
    angles = knots.postures.joint_position.copy()
    knee = knots.task.robot.joint_names.index("FL_calf_joint")
    angles[20, knee] = -0.5
    other = replace(knots)
    vars(other)["postures"] = replace(knots.postures, joint_position=angles)
    need = CONSTRAINT.demand(other).demand
    assert (need.joint, need.needed, need.unit) == ("FL_calf_joint", -0.5, "rad")
    assert need.has == pytest.approx(-0.838, abs=1e-3)
