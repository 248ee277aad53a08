"""Derivatives of functions of functions against CasADi's own of the whole."""

import casadi as ca
import numpy as np
import pytest

from llsrbm.ocp.composition import Composed, Composition, Derived
from llsrbm.ocp.lifting import Lifting
from llsrbm.ocp.stage_functions import make_stage_functions


def derived(name, size, numbers, output):
    v, n = ca.SX.sym("v", size), ca.SX.sym("n", numbers)
    return Derived(name, v, n, output(v, n), Lifting(v))


@pytest.fixture(scope="module")
def stage():
    """Two states, a control; a pendulum's step that is called twice, its numbers swapped."""
    z, s = ca.MX.sym("z", 3), ca.MX.sym("s", 2)
    calls = Composition(z, ca.vertcat(1.0, 2.0, s[0]), s)
    state, control = calls.start.cut(0, 2), calls.start.cut(2, 3)

    def step(v, n):
        return ca.vertcat(v[0] + n[0] * v[1], v[1] + n[1] * ca.sin(v[0]) * v[2])

    one = derived("step", 3, 2, step)
    half = calls(one, [state, control], s)
    end = calls(one, [half, control], s[::-1])
    cost = calls(derived("cost", 3, 0, lambda v, n: ca.sumsqr(v) * v[0]), [half, control], s[:0])
    rows = calls(derived("rows", 4, 0, lambda v, n: v[0] * v[1:]), [state, end], s[:0])
    return Composed(calls, 2, cost, rows, end, (False, True, False))


def whole(stage):
    arguments = [stage.calls.variables, stage.calls.numbers]
    values = [stage.calls.of(stage.cost), stage.constraints()]
    return ca.Function("whole", arguments, values).expand()


@pytest.mark.parametrize("initial", [True, False])
def test_they_are_those_of_the_whole(stage, initial):
    found = make_stage_functions("stage", stage, initial)
    rng = np.random.default_rng(1)
    z, s, lam_f, lam = (rng.normal(size=n) for n in (3, 2, 1, 5))
    x, n = ca.SX.sym("x", 3), ca.SX.sym("n", 2)
    cost, g = whole(stage)(x, n)
    every = [cost, ca.gradient(cost, x), g, ca.jacobian(g, x)]
    every.append(ca.hessian(lam_f * cost + ca.dot(lam, g), x)[0])
    expected = [np.array(value) for value in ca.Function("all", [x, n], every)(z, s)]

    none = np.zeros(0)
    np.testing.assert_allclose(found.cost(z, none, s), expected[0])
    np.testing.assert_allclose(found.gradient(z, none, s), expected[1])
    np.testing.assert_allclose(found.constraints(z, none, s), expected[2])
    values, nonzeros = found.jacobian(z, none, s)
    np.testing.assert_allclose(values, expected[2])
    J = np.array(ca.DM(found.jacobian_pattern, nonzeros))
    np.testing.assert_allclose(J[0 if initial else 2 :], expected[3])
    if not initial:
        np.testing.assert_allclose(J[:2], np.eye(2, 3))
    nonzeros = found.hessian(z, none, s, lam_f, lam)
    H = np.array(ca.DM(found.hessian_pattern, nonzeros))
    np.testing.assert_allclose(H, expected[4], atol=1e-12)
    assert found.equality == (True, True, False, True, False)


def test_parts_have_to_fit(stage):
    with pytest.raises(AssertionError, match="step"):
        stage.calls(derived("step", 3, 0, lambda v, n: v), [stage.calls.start.cut(0, 2)], ca.MX(0))
