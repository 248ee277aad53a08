import copy
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from llsrbm.control import solvers
from llsrbm.control.solvers import Qp, make_solver
from llsrbm.errors import InputError
from tests.llsrbm.control.solvers.programs import program, programs, stationarity, violation

EVERY = pytest.mark.parametrize("name", solvers.names())
# Of the constraints and of the gradient, whose entries are of the order 1 to 100; and how near to a
# limit counts as being at it.
TIGHT = {"proxqp": 2e-5, "quadprog": 1e-7}
ACTIVE = {"proxqp": 2e-2, "quadprog": 1e-6}


def solve(name, *problems):
    """The last solution of one solver that was given the problems one after the other."""
    solver = make_solver(name)
    for p in problems:
        solution = solver.solve(p)
    return solution


def displaced(p, padding):
    """A copy whose arrays start that many bytes after a boundary of 64."""
    copied = {}
    for field in fields(p):
        array = getattr(p, field.name)
        room = np.empty(array.nbytes + 128, dtype=np.uint8)
        start = -room.ctypes.data % 64 + padding
        copied[field.name] = room[start : start + array.nbytes].view(float).reshape(array.shape)
        copied[field.name][:] = array
    return Qp(**copied)


def robot_like(seed, limit=400.0):
    """Weights and scales of the controller's: 18 accelerations, 12 forces, friction, torques."""
    rng = np.random.default_rng(seed)
    p = Qp.zeros(30, 6, 28)
    J = rng.normal(size=(12, 18))
    J[:, :3] = np.tile(np.eye(3), (4, 1))
    p.H[:18, :18] = 1e4 * J.T @ J + np.diag(rng.uniform(0.01, 10, 18))
    p.H[18:, 18:] = 1e-4 * np.eye(12)
    p.g[:18] = -J.T @ (100 * rng.normal(size=12))
    M = rng.normal(size=(18, 18))
    M = M @ M.T / 18 + np.diag([30.0] * 3 + [2.0] * 3 + [0.1] * 12)
    h = np.zeros(18)
    h[2] = 300
    p.A[:, :18], p.A[:, 18:], p.b[:] = M[:6], -J[:, :6].T, -h[:6]
    pyramid = np.array([[1, 0, -0.6], [-1, 0, -0.6], [0, 1, -0.6], [0, -1, -0.6]])
    p.C[:16, 18:], p.upper[:16] = np.kron(np.eye(4), pyramid), 0
    p.C[16:, :18], p.C[16:, 18:] = M[6:], -J[:, 6:].T
    p.lower[16:], p.upper[16:] = -limit, limit
    return p


@EVERY
@settings(max_examples=60, deadline=None)
@given(p=programs())
def test_a_solution_is_feasible_and_optimal(name, p):
    solution = solve(name, p)
    assert solution.solved
    assert violation(p, solution.x) <= TIGHT[name]
    assert stationarity(p, solution.x, ACTIVE[name]) <= 10 * TIGHT[name]


@settings(max_examples=40, deadline=None)
@given(p=programs())
def test_solvers_agree(p):
    exact, other = solve("quadprog", p), solve("proxqp", p)
    cost = [x @ (p.H @ x / 2 + p.g) for x in (exact.x, other.x)]
    assert cost[1] == pytest.approx(cost[0], abs=5e-3, rel=1e-5)
    difference = other.x - exact.x  # near the optimum of a convex cost
    assert difference @ p.H @ difference / 2 < 5e-3


@pytest.mark.parametrize("seed", range(5))
def test_solvers_agree_on_programs_scaled_like_the_controllers(seed):
    p = robot_like(seed)
    exact, other = solve("quadprog", p), solve("proxqp", p)
    assert exact.solved
    assert other.solved
    torques = [(p.C @ x)[16:] for x in (exact.x, other.x)]
    np.testing.assert_allclose(torques[1], torques[0], atol=0.05)


@EVERY
@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_where_no_inequality_is_active_the_library_finds_the_same(name, seed):
    """What is solved without it, by linear equations alone."""
    p = program(seed)
    p.lower[:], p.upper[:] = -np.inf, np.inf
    solver = make_solver(name)
    x = solver.solve(p).x
    p.lower[:], p.upper[:] = p.C @ x - 1.0, p.C @ x + 1.0
    tolerance = 1e-4 if name == "proxqp" else 1e-9
    np.testing.assert_allclose(solver._solve(p), x, rtol=tolerance, atol=tolerance)


@EVERY
def test_a_minimum_by_hand(name):
    # The point nearest to (2, 2, 5) with x + y = 1, x >= 0.8 and z <= 3.
    p = Qp.zeros(3, 1, 2)
    p.H[:], p.g[:] = np.eye(3), [-2, -2, -5]
    p.A[:], p.b[:] = [[1, 1, 0]], 1
    p.C[:] = [[0, 0, 1], [1, 0, 0]]
    p.upper[0], p.lower[1] = 3, 0.8
    np.testing.assert_allclose(solve(name, p).x, [0.8, 0.2, 3], atol=1e-4)


def contradictions():
    equal = program(1)
    equal.A[1], equal.b[1] = equal.A[0], equal.b[0] + 1
    crossed = program(2)
    crossed.lower[0], crossed.upper[0] = 1.0, np.inf
    crossed.C[1], crossed.lower[1], crossed.upper[1] = crossed.C[0], -np.inf, 0.5
    return {"equalities": equal, "inequalities": crossed}


@EVERY
@pytest.mark.parametrize("kind", contradictions())
def test_what_cannot_be_is_not_solved_and_leaves_no_trace(name, kind):
    impossible, possible = contradictions()[kind], program(4)
    assert not solve(name, impossible).solved
    after = solve(name, impossible, impossible, possible)
    assert after.solved
    assert violation(possible, after.x) <= TIGHT[name]
    assert stationarity(possible, after.x, ACTIVE[name]) <= 10 * TIGHT[name]


@EVERY
@pytest.mark.parametrize("part", ["H", "g", "b", "C"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_none_never_raise_and_are_never_solved(name, part, value):
    broken, sound = program(5), program(6)
    getattr(broken, part).flat[0] = value
    assert not solve(name, sound, broken).solved
    after = solve(name, sound, broken, sound)
    assert after.solved
    assert stationarity(sound, after.x, ACTIVE[name]) <= 10 * TIGHT[name]


@EVERY
@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_right_after_a_jump_of_the_program(name, seed):
    """Contacts that come and go, costs and limits that change by orders of magnitude."""
    before, after = program(seed), program(seed + 1)
    after.H *= 1e3
    after.g *= 1e3
    solution = solve(name, before, before, after)
    assert solution.solved
    assert violation(after, solution.x) <= TIGHT[name]
    assert stationarity(after, solution.x, ACTIVE[name]) <= 1e-2 * max(
        1, np.abs(after.g).max() / 1e3
    )


@pytest.mark.parametrize(("name", "tolerance"), [("quadprog", 0.0), ("proxqp", 1e-6)])
def test_the_same_sequence_has_the_same_solutions(name, tolerance):
    """To the last bit with quadprog; ProxQP's depend on where its matrices lie in memory."""
    # Without and with limits that are active.
    sequence = [robot_like(seed, limit=4e4 if seed % 3 else 400.0) for seed in range(9)]
    runs = []
    for padding in range(4):
        solver = make_solver(name)
        runs.append([solver.solve(displaced(p, 8 * padding)).x for p in sequence])
    for run in runs[1:]:
        np.testing.assert_allclose(run, runs[0], rtol=0, atol=tolerance)


@EVERY
def test_the_callers_arrays_stay_as_they_are_and_solutions_are_its_own(name):
    p = program(7)
    copied = copy.deepcopy(p)
    solver = make_solver(name)
    first = solver.solve(p)
    kept = first.x.copy()
    for field in fields(p):
        np.testing.assert_array_equal(getattr(p, field.name), getattr(copied, field.name))
    p.g *= -1
    solver.solve(p)
    np.testing.assert_array_equal(first.x, kept)


def test_names_and_descriptions():
    assert solvers.names() == ("quadprog", "proxqp")


def test_an_unknown_name_lists_the_known_ones():
    with pytest.raises(InputError) as caught:
        make_solver("osqp")
    assert 'no QP solver "osqp"; did you mean "proxqp"?' in str(caught.value)
