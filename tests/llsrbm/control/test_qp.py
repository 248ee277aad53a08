"""The controller's quadratic program against the optimality conditions, and what is no program."""

from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given, settings

from llsrbm.control.qp import SOFTNESS, Qp, check_name
from llsrbm.errors import InputError
from tests.llsrbm.control.programs import program, programs, stationarity, violation

# Of the constraints and of the gradient, whose entries are of the order 1 to 100; and how near to a
# limit counts as being at it.
TIGHT, ACTIVE = 1e-7, 1e-6


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


@settings(max_examples=60, deadline=None)
@given(p=programs())
def test_a_solution_is_feasible_and_optimal(p):
    x = p.solve()
    assert violation(p, x) <= TIGHT
    assert stationarity(p, x, ACTIVE) <= 10 * TIGHT


def test_a_minimum_by_hand():
    # The point nearest to (2, 2, 5) with x + y = 1, x >= 0.8 and z <= 3.
    p = Qp.zeros(3, 1, 2)
    p.H[:], p.g[:] = np.eye(3), [-2, -2, -5]
    p.A[:], p.b[:] = [[1, 1, 0]], 1
    p.C[:] = [[0, 0, 1], [1, 0, 0]]
    p.upper[0], p.lower[1] = 3, 0.8
    np.testing.assert_allclose(p.solve(), [0.8, 0.2, 3], atol=1e-9)


def with_slacks(p):
    """The program whose soft rows are hard ones of C x + s, with slacks s of their weight."""
    n, m, rows = len(p.g), len(p.b), np.vstack([np.eye(len(p.g)), p.soft_rows])
    soft = len(rows)
    slack = Qp.zeros(n + soft, m, len(p.C) + soft)
    slack.H[:n, :n], slack.H[n:, n:], slack.g[:n] = p.H, SOFTNESS * np.eye(soft), p.g
    slack.A[:, :n], slack.b[:] = p.A, p.b
    slack.C[: len(p.C), :n], slack.C[len(p.C) :] = p.C, np.hstack([rows, np.eye(soft)])
    slack.lower[:] = np.concatenate([p.lower, p.soft_lower, p.soft_least])
    slack.upper[:] = np.concatenate([p.upper, p.soft_upper, np.full(soft - n, np.inf)])
    return slack


@pytest.mark.parametrize("seed", range(6))
def test_soft_bounds_and_rows_are_slacks_and_never_make_a_program_infeasible(seed):
    p = program(seed)
    inside = p.solve()
    rng = np.random.default_rng(seed)
    # Some of them exclude what the hard constraints leave.
    side = rng.uniform(-1, 1, len(inside))
    p.soft_lower[:6] = (inside + side)[:6]
    p.soft_upper[6:] = (inside + side)[6:]
    p.soft_rows = rng.normal(size=(3, len(inside)))
    p.soft_least = p.soft_rows @ inside + rng.uniform(-1, 1, 3)
    x = p.solve()
    expected = with_slacks(p).solve()[: len(x)]
    np.testing.assert_allclose(x, expected, atol=1e-6)
    assert violation(p, x) <= TIGHT


def contradictions():
    equal = program(1)
    equal.A[1], equal.b[1] = equal.A[0], equal.b[0] + 1
    crossed = program(2)
    crossed.lower[0], crossed.upper[0] = 1.0, np.inf
    crossed.C[1], crossed.lower[1], crossed.upper[1] = crossed.C[0], -np.inf, 0.5
    return {"equalities": equal, "inequalities": crossed}


@pytest.mark.parametrize("kind", contradictions())
def test_contradicting_constraints_have_no_solution(kind):
    assert contradictions()[kind].solve() is None


@pytest.mark.parametrize("part", ["H", "g", "b", "C"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_not_finite_never_raise_and_are_never_solved(part, value):
    broken = program(5)
    getattr(broken, part).flat[0] = value
    assert broken.solve() is None


def test_the_same_program_has_the_same_solution_to_the_last_bit_wherever_it_lies():
    for seed in range(3):  # without and with limits that are active
        p = robot_like(seed, limit=4e4 if seed % 3 else 400.0)
        first, *others = (displaced(p, 8 * padding).solve() for padding in range(4))
        for x in others:
            np.testing.assert_array_equal(x, first)


def test_the_one_solver_has_a_name():
    check_name("quadprog")
    with pytest.raises(InputError, match='no QP solver "osqp"'):
        check_name("osqp")
    with pytest.raises(InputError, match=r'no QP solver "proxqp"; .*quadprog, .* proxqp, which'):
        check_name("proxqp")
