"""Results of a tab's jobs, as values: plans, simulations, failures."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.panel.acts import Act
from app.panel.status import Verdict
from app.tab.effects import Play, Stop
from app.tab.simulating import status_of
from app.workers.protocol import (
    Cancelled,
    Failed,
    FindNearest,
    Found,
    Planned,
    Progress,
    SeedDone,
    SeedResult,
    Simulated,
    SimulatedSeeds,
    SimulatedSoFar,
)
from llsrbm.request.scenario import Scenario
from tests.app.planners import Nearest
from tests.app.pure_tab import PureTab, plan_of, planned_tab, rollout_of


@pytest.fixture
def tab():
    return planned_tab()


@pytest.fixture
def simulating(tab):
    tab.take(Act.SIMULATE)
    return tab


# ---- plans


def test_while_a_slider_moves_plans_of_older_requests_are_shown(tab):
    submits = []
    for forward in (0.05, 0.1, 0.15):
        tab.move(forward=forward)
        submits.append(tab.one)
    tab.finish_plan(submits[1])
    assert tab.state.plan.jump.forward == 0.1
    assert tab.told[0] is Verdict.PLANNING
    tab.finish_plan(submits[0])  # older than the one that is shown
    assert tab.state.plan.jump.forward == 0.1
    tab.finish_plan(submits[2])
    assert tab.state.plan.jump.forward == 0.15


def test_of_older_jobs_nothing_but_plans_counts(tab):
    tab.move(forward=0.05)
    older = tab.one
    tab.move(forward=0.1)
    before = tab.state
    for report in (
        Progress(0, "solving"),
        Failed(0, "no"),
        Cancelled(0),
        Simulated(0, rollout_of(before.plan)),
    ):
        assert tab.report(report, submit=older) == ()
        assert tab.state is before


def test_a_plan_of_another_robot_is_not_shown(tab):
    tab.move(forward=0.05)
    older = tab.one
    tab.move(robot="go2")
    tab.finish_robot()
    assert tab.finish_plan(older) == ()
    assert tab.state.shown is None


def test_only_the_first_plan_begins_to_play(tab):
    tab.move(forward=0.1)
    tab.finish_plan()
    assert not tab.of(Play)
    tab.move(robot="go2")
    tab.finish_robot()
    tab.finish_plan()
    assert tab.of(Play)


def test_progress_is_on_the_status_line():
    tab = PureTab()
    tab.move(forward=0.1)
    tab.report(Progress(0, "solving", iteration=3, residual=1e-3))
    assert tab.told == (Verdict.PLANNING, "(solving, iteration 3, residual 1.0e-03) ...")
    assert tab.state.status.busy


# ---- failures


def failed(tab, forward=0.1):
    """A request for which nothing is found, neither quickly nor with patience."""
    tab.move(forward=forward)
    tab.report(Failed(0, "no convergence"))
    assert "No quick solution" in tab.told[1]
    tab.take(tab.one.event)
    plan = plan_of(tab.one.task.jump, "not-converged")
    return tab.report(Failed(0, "reach violated", plan))


def test_what_cannot_be_planned_is_drawn_and_the_nearest_looked_for(tab):
    failed(tab)
    jump = tab.state.design.jump
    assert tab.one.task == FindNearest(jump)
    assert not tab.state.plan.solved
    assert tab.told[0] is Verdict.FAILED
    assert "reach violated." in tab.told[1]
    assert "no feasible motion" in tab.told[1]
    assert tab.state.status.busy
    nearer = replace(jump, height=0.1)
    tab.report(Found(0, Nearest(nearer, plan_of(nearer), "height 0.1 m")))
    assert tab.told[1].endswith("It works with height 0.1 m.")
    assert not tab.state.status.busy
    assert tab.state.work.nearest.jump == nearer
    tab.take(Act.NEAREST)
    assert tab.one.task.jump == nearer


def test_an_iterate_that_makes_no_sense_is_not_drawn(tab):
    before = tab.state.shown
    tab.move(forward=0.1, model="srbm")
    plan = plan_of(tab.one.task.jump, "not-converged")
    broken = replace(plan, com=np.full_like(plan.com, np.nan))
    tab.report(Failed(0, "diverged", broken))
    assert tab.state.shown is before
    assert tab.told[1] == "diverged. Looking for the nearest jump ..."


def test_a_refused_request_counts_as_new_when_it_is_made_again(tab):
    tab.move(forward=0.1, model="srbm")
    tab.report(Failed(0, "twist: too much"))
    assert tab.told == (Verdict.FAILED, "twist: too much")
    tab.move()
    assert tab.one.task.jump == tab.state.design.jump


@pytest.mark.parametrize("of", ["plan", "search", "simulation"])
def test_a_job_that_was_cancelled_says_so(tab, of):
    if of == "plan":
        tab.move(forward=0.1)
    elif of == "search":
        failed(tab)
    else:
        tab.take(Act.SIMULATE)
    plan = tab.state.plan
    tab.take(Act.CANCEL)
    assert [type(effect) for effect in tab.effects] == [Stop]
    tab.report(Cancelled(0))
    word, rest = tab.told
    assert word is Verdict.CANCELLED
    assert rest.split()[0] == {"plan": "Move", "search": "The", "simulation": "The"}[of]
    assert not tab.state.status.busy
    assert tab.state.plan is plan
    assert not tab.state.planning


# ---- simulations


def test_a_simulation_is_shown_beside_its_plan(simulating):
    tab = simulating
    assert tab.finish_simulation() == ()
    assert tab.state.rollout.jump == tab.state.plan.jump
    assert tab.state.shown.solid is tab.state.shown.simulated.frames
    assert tab.told[0] is Verdict.LANDED
    tab.move(forward=0.1)
    assert tab.state.rollout is not None  # until there is another plan
    tab.finish_plan()
    assert (tab.state.rollout, tab.state.shown.solid) == (None, None)


def so_far(tab, seconds):
    rollout = rollout_of(plan_of(tab.state.plan.jump))
    part = slice(0, int(seconds * 400), 7)
    return SimulatedSoFar(0, seconds / 2, rollout.time[part], rollout.qpos[part])


def test_frames_so_far_are_shown_until_the_simulation_is_there(simulating):
    tab = simulating
    for seconds in (0.3, 0.6):
        tab.report(so_far(tab, seconds))
        assert tab.state.shown.solid.time[-1] == pytest.approx(seconds, abs=0.03)
        assert tab.state.rollout is None
    tab.report(Progress(0, "simulating", share=0.4))
    assert tab.state.status.share == 0.4
    tab.finish_simulation()
    assert tab.state.shown.so_far is None
    assert tab.state.shown.solid.time[-1] > 2


@pytest.mark.parametrize("end", [Cancelled(0), Failed(0, "the process ended")])
def test_frames_so_far_go_when_it_has_no_end(simulating, end):
    tab = simulating
    tab.report(so_far(tab, 0.3))
    tab.report(end)
    assert tab.state.shown.solid is None
    assert tab.state.plan is not None


def seed(number, landed):
    fell = None if landed else 1.0
    return SeedResult(number, landed, landed, fell, 0.01, "landed" if landed else "fell")


def test_seeds_are_counted_and_the_worst_is_shown_on_demand(tab):
    tab.take(Act.SEEDS)
    results = (seed(0, True), seed(1, False), seed(2, True))
    for done, result in enumerate(results, start=1):
        tab.report(SeedDone(0, result, done, 3))
        assert tab.state.seeds.results == results[:done]
        assert tab.state.status.share == done / 20
    assert tab.take(Act.WORST) == ()
    assert tab.state.rollout is None
    worst = replace(rollout_of(plan_of(tab.state.plan.jump), 1), plan=tab.state.plan)
    tab.report(SimulatedSeeds(0, results, worst))
    assert tab.told == (Verdict.FELL, "in 1 of 3 seeds.")
    tab.take(Act.WORST)
    assert tab.state.rollout is worst
    assert tab.told[1].startswith("seed 1: ")


def test_another_plan_has_no_seeds_yet(tab):
    tab.take(Act.SEEDS)
    worst = rollout_of(plan_of(tab.state.plan.jump), 0)
    tab.report(SimulatedSeeds(0, (seed(0, True),), worst))
    assert tab.told[0] is Verdict.LANDED
    tab.move(forward=0.1)
    tab.finish_plan()
    assert tab.state.seeds is None
    assert tab.take(Act.WORST) == ()
    assert tab.state.rollout is None


def test_a_plan_that_was_asked_for_before_a_file_came_is_dropped(tab):
    tab.move(forward=0.1)
    submit = tab.one
    tab.state = replace(tab.state, work=replace(tab.state.work, dropped=submit.ticket))
    before = tab.state
    assert tab.report(Planned(0, plan_of(submit.task.jump)), submit=submit) == ()
    assert tab.state is before


@pytest.mark.parametrize(
    "scenario", [Scenario(board=0.02), Scenario(seed=1), Scenario(seed=2), Scenario(replan=True)]
)
def test_a_result_of_another_scenario_is_marked(simulating, scenario):
    tab = simulating
    tab.finish_simulation()
    line = status_of(tab.state)
    assert line is tab.state.status
    tab.take(scenario)
    marked = status_of(tab.state)
    assert marked.rest == f"in another scenario, press Simulate: {line.rest}"
    tab.take(Act.UNDO)
    assert status_of(tab.state) == line
    tab.take(scenario)
    tab.take(Act.SIMULATE)
    tab.take(Scenario())  # while it is simulated
    tab.finish_simulation()
    assert "in another scenario" in status_of(tab.state).rest
