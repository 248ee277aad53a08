"""Results of a tab's jobs, as values: plans, simulations, failures."""

from dataclasses import replace

import numpy as np
import pytest

from app.panel.acts import Act
from app.panel.status import SeedResult, Verdict
from app.tab.effects import Play, Stop, Submit
from app.tab.simulating import Automatically, status_of
from app.workers.reports import (
    Cancelled,
    Failed,
    Planned,
    Progress,
    Refused,
    SeedDone,
    Simulated,
    SimulatedSeeds,
    SimulatedSoFar,
)
from app.workers.tasks import PlanJump, SimulateJump
from llsrbm.request.scenario import Scenario
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
        submits.append(tab.submits[-1])
    tab.finish_plan(submits[1])
    assert tab.state.plan.jump.forward == 0.1
    assert tab.told[0] is Verdict.DRAFT
    assert tab.state.status.busy
    tab.finish_plan(submits[0])  # older than the one that is shown
    assert tab.state.plan.jump.forward == 0.1
    tab.finish_plan(submits[2])
    assert tab.state.plan.jump.forward == 0.15


def test_of_older_jobs_nothing_but_answers_counts(tab):
    tab.move(forward=0.05)
    older = tab.submits[-1]
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
    older = tab.submits[-1]
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
    assert tab.told == (Verdict.PLANNING, "(solving, step 3) ...")
    assert tab.state.status.busy


# ---- refusals

REASON = "RH_HAA needs 107 Nm at lift-off, it has 34"


def refusal(task, nearest=None):
    """As a process reports it; `nearest`: changes that make it a jump that can be planned."""
    plan = None if nearest is None else plan_of(replace(task.jump, **nearest))
    return Refused(0, task.jump, REASON, plan_of(task.jump, "not-converged"), plan)


def refuse(tab, nearest=None, **changes):
    """A request that is refused, quickly and once it has rested."""
    tab.move(**changes)
    quick = tab.task
    tab.report(refusal(quick, nearest))
    if not quick.patient:
        tab.wait()
        tab.report(refusal(tab.task if tab.of(Submit) else quick, nearest))


def test_a_refusal_shows_the_nearest_jump_at_once_and_says_why(tab):
    tab.move(forward=0.1)
    asked = tab.task
    tab.report(refusal(asked, {"forward": 0.05}))
    status = tab.state.status
    assert status.verdict is Verdict.NEAREST
    assert status.points == ("Forward 0.05 m instead of 0.1 m.", f"{REASON}.")
    assert status.busy  # it is planned once more when it has rested
    assert tab.state.plan.jump.forward == 0.05
    assert tab.state.shown.remark == "Nearest: forward 0.05 m instead of 0.1 m"
    assert tab.state.design.jump.forward == 0.1, "the controls stay with what was asked for"
    tab.wait()
    assert tab.task == PlanJump(asked.jump)
    assert tab.told[0] is Verdict.NEAREST
    tab.report(refusal(tab.task, {"forward": 0.06}))
    assert tab.state.status.points[0] == "Forward 0.06 m instead of 0.1 m."
    assert not tab.state.status.busy
    assert tab.kept() == [tab.state.design]


def test_the_nearest_moves_with_the_slider(tab):
    submits = []
    for forward in (0.1, 0.2, 0.3):
        tab.move(forward=forward)
        submits.append(tab.submits[-1])
    for submit, nearest in zip(submits, (0.05, 0.06, 0.07)):
        tab.report(refusal(submit.task, {"forward": nearest}), submit=submit)
        assert tab.told[0] is Verdict.NEAREST
        assert tab.state.plan.jump.forward == nearest
        assert tab.state.shown.wanted == submit.task.jump
    tab.move(forward=0.05)
    tab.finish_plan()
    assert (tab.told[0], tab.state.shown.remark) == (Verdict.DRAFT, "")


def test_the_nearest_is_taken(tab):
    assert tab.take(Act.NEAREST) == ()
    refuse(tab, {"forward": 0.05}, forward=0.1)
    nearest = tab.state.plan
    tab.take(Act.NEAREST)
    assert tab.state.design.jump == nearest.jump
    assert tab.state.plan is nearest  # what was shown, to the last bit
    assert not tab.of(Submit)
    assert tab.state.shown.remark == ""
    assert tab.state.history.back[-1].jump.forward == 0.1
    tab.settle()
    assert tab.told[0] is Verdict.DRAFT
    assert tab.take(Act.NEAREST) == ()


def test_the_nearest_is_simulated_pinned_and_undone(tab):
    tab.move(forward=0.1)
    tab.take(Act.SIMULATE)  # while it is planned
    tab.report(refusal(tab.submits[-1].task, {"forward": 0.05}))
    tab.wait()
    tab.report(refusal(tab.task, {"forward": 0.05}))
    (submit,) = tab.of(Submit)
    assert submit.task.plan.jump.forward == 0.05
    tab.finish_simulation()
    assert tab.told[0] is Verdict.LANDED
    assert tab.state.shown.remark.startswith("Nearest"), "it is still not what was asked for"
    tab.take(Act.PIN)
    assert tab.state.pins[0].design.jump.forward == 0.05
    tab.take(Act.UNDO)
    assert (tab.state.plan.jump.forward, tab.state.shown.remark) == (0.01, "")


def test_without_a_nearest_the_last_plan_stays_until_the_request_rests(tab):
    before = tab.state.shown
    tab.move(forward=0.1)
    tab.report(refusal(tab.task))
    assert tab.told[0] is Verdict.INFEASIBLE
    assert tab.state.shown is before
    tab.wait()
    tab.report(refusal(tab.task))
    assert tab.state.status.points[0] == f"{REASON}."
    assert not tab.state.status.busy
    assert not tab.state.plan.solved
    assert "where the planner stopped" in tab.state.shown.remark
    assert tab.take(Act.NEAREST) == ()


def test_an_iterate_that_makes_no_sense_is_not_drawn(tab):
    before = tab.state.shown
    tab.move(forward=0.1, model="srbm")
    plan = plan_of(tab.task.jump, "not-converged")
    broken = replace(plan, com=np.full_like(plan.com, np.nan))
    tab.report(Refused(0, tab.task.jump, "diverged", broken))
    assert tab.state.shown is before
    assert tab.state.status.points[0] == "Diverged."


def test_a_refused_request_counts_as_new_when_it_is_made_again(tab):
    tab.move(forward=0.1, model="srbm")
    tab.report(Failed(0, "twist: too much"))
    assert tab.told == (Verdict.FAILED, "twist: too much")
    tab.move()
    assert tab.task.jump == tab.state.design.jump


@pytest.mark.parametrize("of", ["plan", "simulation"])
def test_a_job_that_was_cancelled_says_so(tab, of):
    if of == "plan":
        tab.move(forward=0.1)
    else:
        tab.take(Act.SIMULATE)
    plan = tab.state.plan
    tab.take(Act.CANCEL)
    assert [type(effect) for effect in tab.effects] == [Stop]
    tab.report(Cancelled(0))
    word, rest = tab.told
    assert word is Verdict.CANCELLED
    assert rest.split()[0] == {"plan": "Move", "simulation": "The"}[of]
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
    assert tab.told[1].startswith("seed 1")


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
    submit = tab.submits[-1]
    tab.state = replace(tab.state, work=replace(tab.state.work, dropped=submit.ticket))
    before = tab.state
    assert tab.report(Planned(0, plan_of(submit.task.jump)), submit=submit) == ()
    assert tab.state is before


@pytest.mark.parametrize(
    "scenario", [Scenario(board=0.02), Scenario(seed=1), Scenario(seed=2), Scenario(replan=True)]
)
def test_a_result_of_another_scenario_is_marked(simulating, scenario):
    tab = simulating
    tab.take(Automatically(False))
    tab.finish_simulation()
    line = status_of(tab.state)
    assert line is tab.state.status
    tab.take(scenario)
    marked = status_of(tab.state)
    assert marked.rest == "Simulated with another scenario: press Simulate"
    assert marked.outdated
    tab.take(Act.UNDO)
    assert status_of(tab.state) == line
    tab.take(scenario)
    tab.take(Act.SIMULATE)
    tab.take(Scenario())  # while it is simulated
    tab.finish_simulation()
    assert status_of(tab.state).outdated


def simulations(tab):
    return [submit.task for submit in tab.of(Submit) if isinstance(submit.task, SimulateJump)]


def test_where_it_is_quick_every_change_is_simulated_once_one_was(tab):
    board = Scenario(board=0.02)
    tab.take(board)
    assert not simulations(tab), "nobody has asked for one"
    tab.take(Act.SIMULATE)
    tab.finish_simulation()
    assert tab.state.automatic
    tab.take(Scenario(seed=1))
    assert [task.scenario for task in simulations(tab)] == [Scenario(seed=1)]
    tab.finish_simulation()
    tab.move(forward=0.1)
    tab.finish_plan()
    assert not simulations(tab), "a hand may still be moving"
    tab.wait()
    tab.finish_plan()
    assert [task.plan.jump.forward for task in simulations(tab)] == [0.1]
    tab.finish_simulation()
    tab.take(Automatically(False))
    tab.take(board)
    assert not simulations(tab)
    tab.take(Automatically(True))
    assert [task.scenario for task in simulations(tab)] == [board]


def test_a_slow_simulation_waits_until_it_is_asked_for(tab):
    tab.take(Act.SIMULATE)
    plan = tab.state.plan
    slow = rollout_of(plan_of(plan.jump))
    slow = replace(slow, plan=plan, outcome=replace(slow.outcome, real_time_factor=0.1))
    tab.report(Simulated(0, slow))
    tab.take(Scenario(seed=1))
    assert not tab.state.automatic
    assert not simulations(tab)
