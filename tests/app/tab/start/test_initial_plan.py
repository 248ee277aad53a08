"""The plan that tabs begin with: kept, recalled, shipped, and not confused with another one."""

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
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.violations import satisfied, violations
from llsrbm.planning.solve.planner import planner_of
from llsrbm.robots import load_robot, names
from tests.app.synthetic_plan import synthetic_plan
from tests.llsrbm.planning.replay import angle_between, replay


@pytest.fixture
def folder(tmp_path, monkeypatch):
    plan = synthetic_plan(example("anymal"))
    monkeypatch.setenv("LLSRBM_CACHE", str(tmp_path))
    InitialPlans("planner").keep(plan)
    return tmp_path


def test_what_one_server_kept_the_next_recalls(folder):
    plans = InitialPlans("planner")
    assert plans.plan("anymal") is None
    plans.recall("anymal")
    plan = plans.plan("anymal")
    assert plan.jump == example("anymal")
    assert np.array_equal(plan.com, synthetic_plan(plan.jump).com)


def test_another_planners_plan_or_another_robots_is_not_recalled(folder):
    for plans, robot in ((InitialPlans("another"), "anymal"), (InitialPlans("planner"), "go2")):
        plans.recall(robot)
        assert plans.plan(robot) is None


def test_a_damaged_entry_counts_as_none(folder, caplog):
    (entry,) = folder.glob("initial-plans-*/*")
    entry.write_bytes(entry.read_bytes()[:-10])
    plans = InitialPlans("planner")
    with caplog.at_level(logging.WARNING):
        plans.recall("anymal")
    assert plans.plan("anymal") is None
    assert "damaged" in caplog.text


def test_a_newer_plan_takes_the_place_of_the_recalled(folder):
    plans = InitialPlans("planner")
    plans.recall("anymal")
    newer = synthetic_plan(example("anymal"))
    plans.keep(newer)
    plans.recall("anymal")
    assert plans.plan("anymal") is newer


def test_a_cache_that_cannot_be_written_is_only_a_warning(tmp_path, monkeypatch, caplog):
    (tmp_path / "file").touch()
    monkeypatch.setenv("LLSRBM_CACHE", str(tmp_path / "file"))
    plans = InitialPlans("planner")
    plan = synthetic_plan(example("anymal"))
    plans.keep(plan)
    assert plans.plan("anymal") is plan
    assert "not kept" in caplog.text


# ---- the plans that come with the package


@pytest.fixture
def no_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("LLSRBM_CACHE", str(tmp_path))


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


@pytest.mark.usefixtures("no_cache")
def test_without_a_kept_plan_tabs_begin_with_the_shipped_one():
    plans = InitialPlans(LIBRARY_PLANNER)
    plans.recall("anymal")
    assert np.array_equal(plans.plan("anymal").com, load_plan(shipped_file("anymal")).com)
    other = InitialPlans("another")
    other.recall("anymal")
    assert other.plan("anymal") is None


@pytest.mark.usefixtures("no_cache")
def test_a_kept_plan_comes_before_the_shipped_one():
    kept = replace(shipped_plan("anymal"), com=shipped_plan("anymal").com + 0.001)
    InitialPlans(LIBRARY_PLANNER).keep(kept)
    plans = InitialPlans(LIBRARY_PLANNER)
    plans.recall("anymal")
    assert np.array_equal(plans.plan("anymal").com, kept.com)


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


@pytest.mark.usefixtures("no_cache")
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
