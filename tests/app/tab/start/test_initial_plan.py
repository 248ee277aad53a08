"""The plan that tabs begin with: the one that ships, and not another one's."""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np
import pytest

from app.tab.start import initial_plan
from app.tab.start.initial_plan import (
    LIBRARY_PLANNER,
    InitialPlans,
    example,
    shipped_file,
    shipped_plan,
)
from app.workers.worker import LibraryPlanner
from llsrbm.models import make_model
from llsrbm.motion.plan import load_plan
from llsrbm.planning.answer.planner import planner_of
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.violations import satisfied, violations
from llsrbm.robots import load_robot, names
from tests.app.synthetic_plan import refined_plan, synthetic_plan
from tests.llsrbm.planning.replay import angle_between, replay


@pytest.mark.parametrize("robot", names())
def test_the_shipped_plan_is_the_examples_of_the_robot_of_today(robot, caplog):
    """Where it fails: python -m benchmarks.initial_plans."""
    plan = shipped_plan(robot)
    assert plan is not None, caplog.text
    assert plan.jump == example(robot)
    loaded = load_robot(robot)
    if loaded.file.foot.is_point:
        # Another integrator comes to the same end.
        end = replay(plan, make_model(plan.jump.model, loaded), step=2e-3)[-1]
        assert np.abs(end.position - plan.com[-1]).max() < 1e-8
        assert angle_between(end.quat, plan.base_quat[-1]) < 0.05


@pytest.mark.parametrize("robot", ["anymal", "slider", "g1"])
def test_a_shipped_plan_satisfies_its_constraints(robot):
    plan = shipped_plan(robot)
    formulation = planner_of(plan.jump, intervals=len(plan.time) - 1).formulation
    knots = formulation.judged(make_task(plan.jump, load_robot(robot)), plan.solution).knots
    assert satisfied(violations(knots))
    assert np.abs(knots.position - plan.com).max() < 1e-9
    assert np.abs(knots.force.reshape(plan.contact_force.shape) - plan.contact_force).max() < 1e-6


def test_tabs_begin_with_the_shipped_plan_until_there_is_a_newer_one():
    plans, other = InitialPlans(LIBRARY_PLANNER), InitialPlans("another")
    for each in (plans, other):
        each.recall("anymal")
    assert np.array_equal(plans.plan("anymal").com, load_plan(shipped_file("anymal")).com)
    assert other.plan("anymal") is None
    newer = refined_plan(synthetic_plan(example("anymal")))
    plans.keep(newer)
    plans.recall("anymal")
    assert plans.plan("anymal") is newer
    plans.keep(synthetic_plan(newer.jump))
    assert plans.plan("anymal") is newer, "no draft in place of a certified plan"


def damage_nothing_but(what):
    """A folder of shipped plans that do not fit."""

    def spoil(folder):
        plan = load_plan(shipped_file("anymal"))
        path = folder / "anymal.npz"
        if what == "request":
            plan = replace(plan, jump=replace(plan.jump, twist=1.0))
        elif what == "robot":
            parameters = {**plan.robot_parameters, "mass": 31.0}
            plan = replace(plan, robot_parameters=parameters)
        elif what == "unsolved":
            plan = replace(plan, report=replace(plan.report, status="not-converged"))
        plan.save(path)
        if what == "schema":
            path.write_bytes(path.read_bytes().replace(b"l", b"m"))
        if what == "missing":
            path.unlink()

    return spoil


@pytest.mark.parametrize(
    ("what", "reason"),
    [
        ("request", "it is of another request"),
        ("robot", "the robot differs (mass)"),
        ("unsolved", "did not converge"),
        ("schema", "anymal.npz"),
        ("missing", "anymal.npz"),
    ],
)
def test_a_shipped_plan_that_does_not_fit_is_not_used_and_the_terminal_says_why(
    tmp_path, monkeypatch, caplog, what, reason
):
    damage_nothing_but(what)(tmp_path)
    monkeypatch.setattr(initial_plan, "shipped_file", lambda robot: tmp_path / f"{robot}.npz")
    plans = InitialPlans(LIBRARY_PLANNER)
    with caplog.at_level(logging.WARNING):
        plans.recall("anymal")
    assert plans.plan("anymal") is None
    assert "is not used: " in caplog.text
    assert reason in caplog.text


def test_the_librarys_planner_is_found_by_its_name():
    assert f"{LibraryPlanner.__module__}.{LibraryPlanner.__qualname__}" == LIBRARY_PLANNER
