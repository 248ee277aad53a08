"""Attempts of a solve: their starts, progress, cancellation, and what is left when all fail."""

import threading
import time
from collections import OrderedDict
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

import llsrbm
from llsrbm.abandon import go_on
from llsrbm.errors import Cancelled, InputError, NotConverged
from llsrbm.motion.sampling import resample
from llsrbm.motion.solve_report import Refinement, Violation
from llsrbm.ocp import progress, solvers
from llsrbm.ocp.horizon import Solution
from llsrbm.planning.answer import nearest, reasons
from llsrbm.planning.answer.nearby import from_nearby
from llsrbm.planning.answer.planner import Planner, planner_for
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.violations import TOLERANCE, excess
from llsrbm.planning.solve import formulation, kept, solver_cache
from llsrbm.planning.solve.formulation import Attempt, Formulation
from llsrbm.planning.solve.jump_layout import INTERVALS
from llsrbm.planning.solve.watch import PlanningProgress, Watch
from llsrbm.planning.whole_body.refine import refined
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.llsrbm.planning.solved import REQUESTS, solved

ROBOT = load_robot("anymal")


@pytest.fixture
def planner():
    """One of its own, to be tampered with; its solver comes from the cache."""
    return Planner(ROBOT, "srbm")


def test_from_a_near_plan_the_same_optimum_is_a_few_iterations_away(planner):
    """The cold solution is the independent truth."""
    near = planner.plan(Jump(model="srbm", twist=1.2, forward=0.1))
    jump = replace(near.jump, twist=1.3, forward=0.07, height=0.02)
    plan, cold = planner.plan(jump, near=near), planner.plan(jump)
    assert plan.report.attempts == 1
    assert plan.report.iterations <= 6 < cold.report.iterations
    assert plan.report.cost == pytest.approx(cold.report.cost, rel=1e-3)
    np.testing.assert_allclose(plan.com, cold.com, atol=3e-3)
    assert max(v.amount for v in plan.violations.values()) <= TOLERANCE


def test_a_plan_from_a_file_can_be_started_from(planner, tmp_path):
    near = solved("srbm", "forward").plan
    near.save(tmp_path / "plan.npz")
    jump = replace(near.jump, twist=near.jump.twist + 0.05)
    here = planner.plan(jump, near=near)
    there = planner.plan(jump, near=llsrbm.load(tmp_path / "plan.npz"))
    assert there.report.attempts == 1
    assert there.report.iterations == here.report.iterations
    np.testing.assert_array_equal(there.com, here.com)


def test_a_refined_plan_can_be_started_from_whatever_its_knots(planner):
    """It has more of them where a phase has an odd number of intervals; its solution has not."""
    near = solved("srbm", "forward").plan
    jump = replace(near.jump, twist=near.jump.twist + 0.05)
    second = Refinement("solved", *[0] * 5)
    other = resample(near, np.linspace(0.0, near.duration, len(near.time) + 2))
    other = replace(other, solution=near.solution, refinement=second)
    np.testing.assert_array_equal(
        planner.plan(jump, near=other).com, planner.plan(jump, near=near).com
    )
    with pytest.raises(InputError, match="cannot be started from"):
        planner.plan(jump, near=replace(other, refinement=None))


def test_what_cannot_be_started_from(planner):
    jump = Jump(model="srbm", forward=0.3)
    near = solved("srbm", "forward").plan
    with pytest.raises(InputError, match="cannot be started from; expected one that converged"):
        planner.plan(jump, near=replace(near, solution=None))
    short = replace(near.solution, multipliers=near.solution.multipliers[:-1])
    with pytest.raises(InputError, match="of another version of the planner"):
        planner.plan(jump, near=replace(near, solution=short))
    with pytest.raises(InputError, match="expected anymal as it is now with srbm and 48 int"):
        planner.plan(jump, near=solved("llsrbm", "forward").plan)


class Reluctant:
    """A solver whose first solves end where they began."""

    def __init__(self, solver, failures):
        self.solver, self.failures, self.calls, self.seconds = solver, failures, [], []
        self.name, self.sizes, self.function = solver.name, solver.sizes, solver.function

    def solve(self, problem, guess, options=solvers.FROM_GUESS, read=None):
        self.calls.append(guess)
        return self._spoilt(self.solver.solve(problem, guess, options, read), guess)

    def follow(self, problem, start):
        self.calls.append(start.variables)
        return self._spoilt(self.solver.follow(problem, start), start.variables)

    def _spoilt(self, solution, start):
        self.seconds.append(solution.solve_time_s)
        if len(self.calls) <= self.failures:
            spoilt = {"variables": start, "converged": False, "message": "reluctant"}
            solution = replace(solution, **spoilt)
        return solution


def made_reluctant(planner, failures):
    solver = Reluctant(planner.formulation.solver, failures)
    planner.formulation = replace(planner.formulation, solver=solver)
    return solver


def attempt_of(converged, torque, jump=None):
    """One that needs `torque` Nm too much."""
    found = {"joint_torque": Violation(torque, "Nm", "flight", 0.5)}
    solution = Solution(np.zeros(1), np.zeros(1), converged, 7, 0.0, 1.0, 0.0, "")
    task = SimpleNamespace(jump=jump, correction=None, penalty=0.0, agrees=True)
    return Attempt(task, solution, None, found)


DIVERGED, WORSE, LITTLE = (False, 400.0), (True, 2.0), (True, 0.3)


@pytest.mark.parametrize("later", [[WORSE, DIVERGED], [(False, 0.01)]])
def test_of_several_solves_the_best_is_kept(planner, monkeypatch, later):
    """In all three places where a solve follows another one; time is that of all."""
    form, first = planner.formulation, attempt_of(*LITTLE)
    solves = iter([attempt_of(*each) for each in later] * 3)
    monkeypatch.setattr(Formulation, "with_shifted_bounds", lambda *_: None)
    monkeypatch.setattr(Formulation, "again", lambda *_, **__: next(solves))
    kept = form.reconciled(first, Watch())
    assert kept.violations == first.violations
    assert kept.converged
    assert kept.solution.solve_time_s > 1.0

    judged = iter([first, attempt_of(*later[0])])
    monkeypatch.setattr(Formulation, "problem", lambda *_: None)
    monkeypatch.setattr(Formulation, "judged", lambda *_: next(judged))
    monkeypatch.setattr(formulation, "mended", lambda _: frozenset())
    monkeypatch.setattr(Watch, "over", lambda *_: None)
    kept = form.follow(None, None, Watch())
    assert kept.violations == first.violations
    assert kept.solution.solve_time_s == 2.0

    monkeypatch.setattr(form.solver, "miss", lambda *_: 0.0)
    monkeypatch.setattr(Formulation, "follow", lambda *_: first)
    monkeypatch.setattr(Formulation, "solve", lambda *_: attempt_of(*later[0]))
    kept = from_nearby(form, first.solution, None, Watch())
    assert kept.violations == first.violations


def test_the_nearest_that_was_found_first_is_not_dropped_for_a_further_one(monkeypatch):
    asked, little, much = (Jump(twist=twist) for twist in (1.0, 0.9, 0.4))
    task = replace(make_task(asked, ROBOT), requested=asked)
    form, priced = SimpleNamespace(), attempt_of(*LITTLE, asked)
    form.solve, form.reconciled = lambda *_: priced, lambda attempt, _: attempt
    rounds = iter([attempt_of(True, 0.0, little), attempt_of(True, 0.0, much)])
    monkeypatch.setattr(nearest, "starts", lambda *_: [(None, None, task)])
    monkeypatch.setattr(nearest, "_falls_short", lambda *_: False)
    monkeypatch.setattr(nearest, "_in_whole_steps", lambda *_: next(rounds))
    monkeypatch.setattr(nearest, "_dearer", lambda *_: [attempt_of(*LITTLE)])
    assert nearest.find_nearest(form, task, Watch()).plain.task.jump == little


def test_an_attempt_is_told(planner):
    solver = made_reluctant(planner, 0)
    said = []
    plan = planner.plan(Jump(model="srbm", forward=0.3), progress=said.append)
    assert plan.solved
    assert plan.report.attempts == len(solver.calls) == 1
    assert [news.text for news in said if news.iteration is None] == [
        "attempt 1: from the analytic guess"
    ]
    assert plan.report.solve_time_s == pytest.approx(sum(solver.seconds), rel=0.05)
    assert plan.report.cost == pytest.approx(solved("srbm", "forward").plan.report.cost, rel=5e-3)


def test_what_cannot_be_says_what_was_tried(planner):
    """Where no nearer jump is looked for; the attempt ends as it began, far from any motion."""
    made_reluctant(planner, 99)
    with pytest.raises(NotConverged) as caught:
        planner.plan(Jump(model="srbm", forward=0.3), patient=False)
    message, plan = str(caught.value), caught.value.plan
    assert "\n" not in message
    assert message.startswith(
        "no plan found in 1 attempt (twist 0 deg, forward 0.3 m, lateral 0 m, height 0 m, srbm): "
    )
    _, v = max(plan.violations.items(), key=lambda item: excess(dict([item])))
    assert v.amount > TOLERANCE
    assert not plan.solved
    assert plan.report.status == "not-converged"
    assert plan.report.attempts == 1
    assert caught.value.nearest is None
    assert message.endswith(reasons.ASTRAY)
    assert caught.value.stops == ()
    assert plan.com.shape == (INTERVALS + 1, 3)
    with pytest.raises(InputError, match="no solution yet"):
        planner.last_knots()


@pytest.mark.parametrize("converged", [True, False])
def test_numbers_of_where_a_solver_got_lost_are_not_told(monkeypatch, converged):
    """An A1 that turned over "needed 320 rad/s", as the solver had diverged."""
    monkeypatch.setattr(reasons, "stops", lambda _: ())
    attempt, plan = attempt_of(converged, 400.0), solved("srbm", "forward").plan
    task = make_task(Jump(model="srbm", forward=0.3), ROBOT)
    error = reasons.unexplained(task, attempt, plan)
    assert ("400 Nm" in str(error)) == converged
    assert (error.reason == " and ".join(map(str, error.stops[:2]))) == converged
    assert (reasons.ASTRAY in str(error)) == (error.reason == reasons.ASTRAY) == (not converged)


def test_a_near_plan_that_leads_nowhere_costs_an_attempt(planner):
    near = solved("srbm", "forward").plan
    solver = made_reluctant(planner, 1)
    said = []
    plan = planner.plan(Jump(model="srbm", forward=0.32), near=near, progress=said.append)
    assert plan.solved
    assert plan.report.attempts == len(solver.calls) == 2
    assert said[0].text == "attempt 1: from the last plan"
    np.testing.assert_array_equal(
        plan.com, planner.plan(Jump(model="srbm", forward=0.32)).com, "from the analytic guess"
    )


def test_impatient_planning_gives_up_after_the_quick_attempts(planner):
    solver = made_reluctant(planner, 9)
    with pytest.raises(NotConverged, match="no plan found in 2 attempts"):
        planner.plan(
            Jump(model="srbm", forward=0.3), near=solved("srbm", "forward").plan, patient=False
        )
    assert len(solver.calls) == 2


def test_cancelled_in_the_middle_of_a_solve(planner):
    """The solve goes on unseen; the next plan waits for it and is what it always is."""
    jump = Jump(model="srbm", **REQUESTS["all"])
    planner.plan(jump)  # whatever is done once is done
    begun, release = threading.Event(), threading.Event()
    solver = planner.formulation.solver
    solve = solver._run

    def slow(*arguments):
        begun.set()
        release.wait(30)
        return solve(*arguments)

    solver._run = slow
    with pytest.raises(Cancelled):
        planner.plan(jump, cancelled=begun.is_set)
    solver._run = solve
    threading.Timer(0.1, release.set).start()
    again = planner.plan(jump)
    assert release.is_set()
    np.testing.assert_array_equal(again.com, solved("srbm", "all").plan.com)


@pytest.mark.parametrize("what", ["plan", "refine", "simulate"])
def test_cancelled_while_a_solver_is_built(what, monkeypatch):
    """At once, whatever it is built for; and the building ends, too."""
    plan = solved("srbm", "forward").plan
    begun, ended = threading.Event(), threading.Event()

    def build(*_):
        begun.set()
        try:
            while True:
                go_on()
                time.sleep(0.01)
        finally:
            ended.set()

    monkeypatch.setattr(solver_cache, "Transcription", build)
    monkeypatch.setattr(solver_cache, "cached_bytes", lambda *parts: parts[-1]())
    monkeypatch.setattr(kept, "_holders", OrderedDict())
    ask = {
        "plan": partial(llsrbm.plan, plan.jump),
        "refine": partial(refined, plan),
        "simulate": partial(llsrbm.simulate, plan, replan=True),
    }[what]
    with pytest.raises(Cancelled):
        ask(cancelled=begun.is_set)
    assert ended.wait(30)


def test_iterations_are_told_while_a_solve_runs(capfd, monkeypatch):
    monkeypatch.setattr(progress, "REPORT_INTERVAL", 0.0)
    monkeypatch.setattr(progress, "POLL_INTERVAL", 1e-3)
    planner = planner_for("anymal", "llsrbm-plus")
    said, threads = [], set()

    def hear(news):
        said.append(news)
        threads.add(threading.get_ident())

    jump = Jump(**REQUESTS["all"])
    plan = planner.plan(jump, progress=hear)
    np.testing.assert_array_equal(plan.com, solved("llsrbm-plus", "all").plan.com)
    assert said[0] == PlanningProgress("attempt 1: from the analytic guess")
    assert {news.text for news in said} == {said[0].text}
    numbers = [news.iteration for news in said[1:]]
    assert len(numbers) >= 3
    assert numbers == sorted(set(numbers))
    assert 0 <= numbers[0] <= numbers[-1] <= plan.report.iterations
    assert said[-1].residual < said[1].residual
    assert threads == {threading.get_ident()}
    planner.plan(jump)  # silent again
    assert capfd.readouterr() == ("", "")
