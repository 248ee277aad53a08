"""A problem without robots, solved and compared with what pencil and paper give."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from llsrbm.ocp import solvers
from llsrbm.ocp.solvers import FROM_GUESS, WITHIN, SolveOptions
from llsrbm.ocp.solvers.base import MAX_FOLLOW_MISS
from llsrbm.ocp.transcription import Transcribed
from tests.llsrbm.ocp.cart import (
    INTERVALS,
    best_pushes,
    places,
    problem,
    pushes,
    transcription,
)

every_solver = pytest.mark.parametrize("name", solvers.names())
GUESS = np.zeros(3 * INTERVALS + 2)


@cache
def solver(name):
    return solvers.by_name(name)(transcription())


@every_solver
def test_the_closed_form(name):
    """With equal weights the pushes fall evenly and cost 12 x^2 / (T^3 (1 - 1 / N^2))."""
    solution = solver(name).solve(problem(1.0), GUESS)
    assert solution.converged
    fall = 6 / (INTERVALS * 2.0**2 * (1 - 1 / INTERVALS**2))
    expected = fall * (INTERVALS - 1 - 2 * np.arange(INTERVALS))
    np.testing.assert_allclose(pushes(solution.variables), expected, atol=1e-4)
    assert solution.cost == pytest.approx(12 / 2.0**3 / (1 - 1 / INTERVALS**2), rel=1e-4)
    assert places(solution.variables)[[0, -1]] == pytest.approx([0.0, 1.0], abs=1e-5)


@every_solver
def test_runs_of_one_family_have_their_own_parameters(name):
    weights = (1.0, 3.0)
    solution = solver(name).solve(problem(0.8, weights=weights), GUESS)
    np.testing.assert_allclose(
        pushes(solution.variables), best_pushes(0.8, weights=weights), atol=1e-3
    )


@every_solver
def test_multipliers_balance_the_cost(name):
    """grad f + J^T lam = 0 at the optimum."""
    task = problem(0.8, drag=0.5)
    solution = solver(name).solve(task, GUESS)
    slope = solver(name).function("nlp_grad_f")(solution.variables, task.parameters)
    gradient = np.array(slope).ravel()
    J = np.array(solver(name).function("nlp_jac_g")(solution.variables, task.parameters)[1])
    np.testing.assert_allclose(gradient + J.T @ solution.multipliers, 0.0, atol=1e-3)


def test_bounds_are_kept_and_both_solvers_agree():
    """A push of 1.1 m/s2 barely does: to push all the time forth and back takes 1."""
    task = problem(1.0, push=1.1)
    one, other = (solver(name).solve(task, GUESS) for name in solvers.names())
    assert one.converged
    assert other.converged
    assert np.abs(pushes(one.variables)).max() < 1.1 + 1e-4
    np.testing.assert_allclose(pushes(one.variables), pushes(other.variables), atol=5e-3)
    assert best_pushes(1.0).max() > 1.1


def test_every_row_has_a_bound():
    """Without, a solver of Fatrop's loses its options, from the next solve on."""
    task = problem(1.0)
    lower = np.where(task.lower < task.upper, -np.inf, task.lower)
    replace(task, lower=lower)
    with pytest.raises(ValueError, match="rows need a bound, a far one if no other: "):
        replace(task, lower=lower, upper=np.where(np.isinf(lower), np.inf, task.upper))


@every_solver
def test_to_follow_is_quicker_and_ends_at_the_same_place(name):
    near = solver(name).solve(problem(1.0, drag=0.5), GUESS)
    task = problem(1.05, drag=0.5)
    followed, cold = solver(name).follow(task, near), solver(name).solve(task, GUESS)
    assert followed.converged
    assert followed.iterations <= cold.iterations
    np.testing.assert_allclose(followed.variables, cold.variables, atol=1e-3)


@every_solver
def test_rows_that_are_large_are_followed(name):
    """Squared distances begin at 60, and with no number beyond 40 Fatrop never returned."""
    target = 1.5 * WITHIN
    near = solver(name).solve(problem(target), GUESS)
    rows = np.array(solver(name).function("nlp_g")(near.variables, problem(target).parameters))
    assert np.abs(rows).max() > WITHIN
    followed = solver(name).follow(problem(target + 0.05), near)
    assert followed.converged
    assert places(followed.variables)[-1] == pytest.approx(target + 0.05, abs=1e-4)


def test_what_is_too_far_is_not_begun():
    near = solver("fatrop").solve(problem(1.0), GUESS)
    far = problem(1.0 + 1.01 * MAX_FOLLOW_MISS)
    followed = solver("fatrop").follow(far, near)
    assert (followed.converged, followed.iterations) == (False, 0)
    np.testing.assert_array_equal(followed.variables, near.variables)
    for guess in (np.full_like(GUESS, 1e6), np.full_like(GUESS, np.nan)):
        assert not solver("fatrop").solve(far, guess).converged


@pytest.mark.parametrize("multiplier", [1e7, 1e17, np.inf, np.nan])
def test_a_start_with_multipliers_of_no_room_is_not_begun(multiplier):
    """Rows scaled by them once kept Fatrop looking for a direction for ever."""
    task = problem(1.0, push=1.1)
    near = solver("fatrop").solve(task, GUESS)
    row = np.flatnonzero(task.lower < task.upper)[3]
    multipliers = np.where(np.arange(near.multipliers.size) == row, multiplier, near.multipliers)
    followed = solver("fatrop").follow(task, replace(near, multipliers=multipliers))
    assert (followed.converged, followed.iterations) == (False, 0)


@every_solver
def test_miss_is_the_largest_violation(name):
    assert solver(name).miss(problem(0.7), GUESS) == pytest.approx(0.7)
    broken = np.where(np.arange(GUESS.size) == 5, np.nan, GUESS)
    assert solver(name).miss(problem(0.7), broken) == np.inf


@every_solver
def test_from_text_it_is_the_same(name):
    here = solver(name)
    there = solvers.by_name(name)(Transcribed.deserialize(transcription().serialize()))
    assert there.sizes == here.sizes == (GUESS.size, problem(1.0).lower.size)
    task = problem(0.9, drag=0.3)
    np.testing.assert_array_equal(
        there.solve(task, GUESS).variables, here.solve(task, GUESS).variables
    )
    hurried = SolveOptions(mu=1e-3, iterations=60)
    np.testing.assert_array_equal(
        there.solve(task, GUESS, hurried).variables, here.solve(task, GUESS, hurried).variables
    )


def test_the_table_is_read_and_nothing_printed(capfd):
    """From the first solve of a solver on, with any options."""
    fatrop = solvers.by_name("fatrop")(transcription())
    for options in (FROM_GUESS, SolveOptions(mu=2e-3, iterations=50)):
        read = []
        assert fatrop.solve(problem(1.0), GUESS, options, read.append).converged
        assert "inf_pr" in "".join(read)
    fatrop.solve(problem(1.0), GUESS, SolveOptions(mu=3e-3, iterations=50))
    fatrop.follow(problem(1.01), fatrop.solve(problem(1.0), GUESS), acceptable=(5e-3, 1))
    assert capfd.readouterr() == ("", "")


@every_solver
def test_memory_of_many_options_is_bounded_and_counted(name, monkeypatch):
    """Where all do not fit in, the one used last stays; a solve is the same with one made anew."""
    one, other = FROM_GUESS, replace(FROM_GUESS, mu=1e-3)
    several = solvers.by_name(name)(transcription())
    empty = several.megabytes
    first = several.solve(problem(1.0), GUESS, one)
    alone = several.megabytes
    several.solve(problem(1.0), GUESS, other)
    assert empty < alone < several.megabytes
    monkeypatch.setattr("llsrbm.ocp.solvers.base.MOST_MADE", 0.0)
    again = several.solve(problem(1.0), GUESS, one)
    assert several.megabytes == pytest.approx(alone)
    np.testing.assert_array_equal(again.variables, first.variables)
