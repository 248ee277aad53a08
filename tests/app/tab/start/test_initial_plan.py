"""The plan that tabs begin with: the one that ships, and not another one's."""

import logging
from dataclasses import replace

import numpy as np
import pytest

import llsrbm
from app.tab.start import initial_plan
from app.tab.start.initial_plan import (
    LIBRARY_PLANNER,
    InitialPlans,
    example,
    shipped_file,
    shipped_plan,
)
from app.workers.worker import LibraryPlanner
from llsrbm.motion.plan import load_plan
from llsrbm.robots import names
from tests.app.synthetic_plan import refined_plan, synthetic_plan


@pytest.mark.parametrize("robot", names())
def test_the_shipped_plan_is_the_examples_of_the_robot_of_today(robot, caplog):
    """Where it fails: python -m benchmarks.initial_plans."""
    plan = shipped_plan(robot)
    assert plan is not None, caplog.text
    assert plan.jump == example(robot)
    assert not llsrbm.certify(plan).broken
    assert plan.certified


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
