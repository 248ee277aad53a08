"""The plan that tabs begin with: kept, recalled, and not confused with another planner's."""

from __future__ import annotations

import logging

import numpy as np
import pytest

from app.session.initial_plan import InitialPlans, example
from tests.app.synthetic_plan import synthetic_plan


@pytest.fixture
def folder(tmp_path, monkeypatch):
    plan = synthetic_plan(example("anymal"))
    monkeypatch.setenv("LLSRBM_CACHE", str(tmp_path))
    InitialPlans("planner").keep(plan)
    return tmp_path


def test_what_one_server_kept_the_next_recalls(folder):
    opening = InitialPlans("planner")
    assert opening.plan("anymal") is None
    opening.recall("anymal")
    plan = opening.plan("anymal")
    assert plan.jump == example("anymal")
    assert np.array_equal(plan.com, synthetic_plan(plan.jump).com)


def test_the_example_is_the_robot_files():
    assert (example("anymal").robot, round(example("anymal").twist, 3)) == ("anymal", 1.571)


def test_another_planners_plan_or_another_robots_is_not_recalled(folder):
    for opening, robot in ((InitialPlans("another"), "anymal"), (InitialPlans("planner"), "go2")):
        opening.recall(robot)
        assert opening.plan(robot) is None


def test_a_damaged_entry_counts_as_none(folder, caplog):
    (entry,) = (folder / "opening").iterdir()
    entry.write_bytes(entry.read_bytes()[:-10])
    opening = InitialPlans("planner")
    with caplog.at_level(logging.WARNING):
        opening.recall("anymal")
    assert opening.plan("anymal") is None
    assert "damaged" in caplog.text


def test_a_newer_plan_takes_the_place_of_the_recalled(folder):
    opening = InitialPlans("planner")
    opening.recall("anymal")
    newer = synthetic_plan(example("anymal"))
    opening.keep(newer)
    opening.recall("anymal")
    assert opening.plan("anymal") is newer


def test_a_cache_that_cannot_be_written_is_only_a_warning(tmp_path, monkeypatch, caplog):
    (tmp_path / "file").touch()
    monkeypatch.setenv("LLSRBM_CACHE", str(tmp_path / "file"))
    opening = InitialPlans("planner")
    plan = synthetic_plan(example("anymal"))
    opening.keep(plan)
    assert opening.plan("anymal") is plan
    assert "not kept" in caplog.text
