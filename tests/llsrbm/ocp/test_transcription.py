"""The functions of a problem without robots against differences and against its definition."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from llsrbm.ocp.horizon import Horizon
from llsrbm.ocp.lifting import Lifting
from llsrbm.ocp.transcription import Transcription
from tests.llsrbm.ocp.cart import INTERVALS, expressions, horizon, problem

every_start = pytest.mark.parametrize("fixed", [True, False])
NUMBERS = problem(1.0, drag=0.7, weights=(1.0, 3.0)).parameters
VARIABLES = 3 * INTERVALS + 2


def values(function, *arguments):
    return [np.array(out) for out in function.call(arguments)]


def test_structure():
    structure = Transcription(horizon()).structure
    assert structure.states == [2] * (INTERVALS + 1)
    assert structure.controls == [1] * INTERVALS + [0]
    assert structure.rows == [3, *[1] * (INTERVALS - 1), 2]
    first, inner = [True] * 4 + [False], [True, True, False]
    assert structure.equality == first + (INTERVALS - 1) * inner + [True, True]


@every_start
def test_cost_and_rows_are_the_definitions(fixed):
    """Stage after stage by NumPy."""
    x = np.random.default_rng(1).normal(size=VARIABLES)
    cost, g = values(Transcription(horizon(fixed=fixed)).functions["nlp"], x, NUMBERS)
    duration, drag, *weights = NUMBERS
    dt, rows, total = duration / INTERVALS, [], 0.0
    stages = x[:-2].reshape(INTERVALS, 3)
    for k, (place, v, u) in enumerate(stages):
        step = (u - drag * np.sin(v)) * dt
        after = x[3 * (k + 1) :][:2]
        rows += [after - [place + (v + step / 2) * dt, v + step]]
        rows += [stages[k, :2]] if fixed and k == 0 else []
        rows += [[u]]
        total += weights[k >= INTERVALS // 2] * u**2 * dt
    np.testing.assert_allclose(g.ravel(), np.concatenate([*rows, x[-2:]]), atol=1e-14)
    assert cost.item() == pytest.approx(total, rel=1e-13)


@every_start
def test_derivatives_against_differences(fixed):
    functions = Transcription(horizon(fixed=fixed)).functions
    rng = np.random.default_rng(0)
    x, step = rng.normal(size=VARIABLES), 1e-6
    rows = functions["nlp"].size1_out(1)
    lam_f, lam = 0.6, rng.normal(size=rows)
    _, J = values(functions["nlp_jac_g"], x, NUMBERS)
    _, H = values(functions["nlp_hess_l"], x, NUMBERS, lam_f, lam)
    (gradient,) = values(functions["nlp_grad_f"], x, NUMBERS)
    for column in range(VARIABLES):
        moved = step * np.eye(VARIABLES)[column]
        (f1, g1), (f0, g0) = (
            values(functions["nlp"], x + sign * moved, NUMBERS) for sign in (1, -1)
        )
        slopes = [
            values(functions["nlp_grad"], x + sign * moved, NUMBERS, lam_f, lam)[2]
            for sign in (1, -1)
        ]
        np.testing.assert_allclose(J[:, column], (g1 - g0).ravel() / (2 * step), atol=1e-8)
        np.testing.assert_allclose(
            H[:, column], (slopes[0] - slopes[1]).ravel() / (2 * step), atol=1e-8
        )
        assert gradient[column, 0] == pytest.approx((f1 - f0).item() / (2 * step), abs=1e-7)


def test_stages_that_do_not_fit_are_refused():
    whole = horizon()

    def narrow():
        z = ca.SX.sym("z", 1)
        last = expressions("last", [])
        return replace(last, variables=z, states=1, rows=(), cost=z, lift=Lifting(z))

    runs = (*whole.runs[:-1], replace(whole.runs[-1], build=narrow))
    with pytest.raises(
        ValueError, match=f"stage {INTERVALS - 1} leads to 2 states; the next has 1"
    ):
        Transcription(Horizon(runs, whole.parameters))
