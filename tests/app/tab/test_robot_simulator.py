"""The robot simulator in a tab, as values: what is asked for, and what stands beside it."""

from dataclasses import replace

import pytest

from app.panel.acts import Act
from app.panel.status import Verdict
from app.tab.effects import Notify
from app.workers.reports import Simulated
from app.workers.tasks import SimulateJump
from llsrbm.request.scenario import Push, Scenario
from tests.app.pure_tab import planned_tab, rollout_of


@pytest.fixture
def tab():
    return planned_tab()


def test_the_plan_is_played_through_the_wire_and_shown(tab):
    plan, scenario = tab.state.plan, tab.state.design.scenario
    tab.take(Act.ROBOT_SIMULATOR)
    task = tab.one.task
    assert isinstance(task, SimulateJump)
    assert (task.plan, task.scenario, task.wire) == (plan, scenario, True)
    assert tab.state.pins == ()
    played = replace(rollout_of(plan), plan=plan)
    tab.report(Simulated(0, played))
    assert tab.state.rollout is played
    assert tab.told[1].startswith("robot simulator")
    assert not tab.state.outdated


def test_the_direct_simulation_is_pinned_beside_it(tab):
    tab.take(Act.SIMULATE)
    tab.finish_simulation()
    direct = tab.state.rollout
    tab.take(Act.ROBOT_SIMULATOR)
    assert [pin.rollout for pin in tab.state.pins] == [direct]


def test_pushes_are_refused_in_words(tab):
    tab.take(Scenario(pushes=(Push(0.1, (1.0, 0.0, 0.0)),)))
    tab.take(Act.ROBOT_SIMULATOR)
    assert [note.title for note in tab.of(Notify)] == ["Not played"]
    assert tab.state.status.verdict is not Verdict.SIMULATING
