"""Solvers that will be wanted next are built by a process of their own."""

import json
import math
import subprocess
import sys
from dataclasses import replace
from types import SimpleNamespace

import pytest

from app.workers import spare_solvers
from app.workers.tasks import PlanJump
from app.workers.worker import LibraryPlanner
from llsrbm.ocp.compiled import asker
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.app.synthetic_plan import synthetic_plan

JUMP = Jump(robot="go2", twist=math.radians(20), forward=0.05)


@pytest.fixture
def started(monkeypatch):
    """Commands that were started, and how."""
    commands = []
    made = SimpleNamespace(Popen=lambda command, **how: commands.append((command, how)))
    monkeypatch.setattr(spare_solvers, "subprocess", made)
    return commands


@pytest.fixture
def patient(monkeypatch):
    """What the process that builds does first, which the tests' process does not do."""
    first = []
    monkeypatch.setattr(spare_solvers, "end_with", first.append)
    monkeypatch.setattr(spare_solvers, "yield_to_others", lambda: first.append("yields"))
    return first


@pytest.mark.parametrize("there", [False, True])
def test_a_process_of_its_own_builds_what_is_not_there(started, patient, monkeypatch, there):
    built = []
    planner = SimpleNamespace(plan=lambda jump: jump, robot=load_robot("go2"))

    def planner_of(jump, limits=None):
        built.append(limits)
        return planner

    monkeypatch.setattr("llsrbm.planning.answer.planner.planner_of", planner_of)
    monkeypatch.setattr(
        "llsrbm.planning.answer.planner.is_planner_built",
        lambda jump, limits: there and (jump, limits) == (JUMP, spare_solvers._free_apex()),
    )
    monkeypatch.setattr(
        "llsrbm.simulation.replanning.Replanning", lambda *numbers: built.append(numbers[0])
    )
    spare_solvers.build(JUMP)
    ((command, how),) = started
    assert command[:3] == [sys.executable, "-m", "app.workers.spare_solvers"]
    # It ends with the process that started it, and reads nothing of its terminal.
    assert how == {"stdin": asker(), "start_new_session": True}
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(fileno=lambda: 0))
    spare_solvers.main(*command[3:])
    assert built == ([] if there else [None, spare_solvers._free_apex(), JUMP])
    assert patient == [0, "yields"]


def test_a_slider_that_moves_has_them_built_once_and_looks_for_none(started, monkeypatch):
    """What to look for them takes is seconds, on a machine that has none."""
    looked_for, asked = [], []
    monkeypatch.setattr(
        "llsrbm.planning.answer.planner.is_planner_built",
        lambda jump, limits: looked_for.append(limits),
    )

    def plan(jump, *, patient, hurried, **how):
        asked.append((patient, hurried))
        return synthetic_plan(jump)

    monkeypatch.setattr("llsrbm.plan", plan)
    planner = LibraryPlanner()
    for twist in (0.1, 0.2):
        task = PlanJump(replace(JUMP, twist=twist), patient=False)
        planner.plan(task, lambda *_, **__: None, lambda: False)
    assert asked == [(True, True)] * 2  # nearer jumps are looked for, in a hurry
    assert len(started) == 1
    assert looked_for == [{}]  # the plan's own, to say what it takes


def test_it_ends_with_its_asker_without_a_word():
    """While it imports or builds."""
    jump = json.dumps(JUMP.as_dict())
    process = subprocess.Popen(
        [sys.executable, "-m", "app.workers.spare_solvers", jump],
        stdin=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    _, err = process.communicate(timeout=60)  # closes its standard input at once
    assert err == b""
