"""Vector evaluation of stages against CasADi's own evaluation, one column after another."""

import casadi as ca
import numpy as np
import pytest

from llsrbm.ocp.stage_functions import WORTHWHILE, batched


def deep_function() -> ca.Function:
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 2)
    a = ca.sin(x[0]) * p[0] - ca.sqrt(x[1] ** 2 + 1) / (2 + ca.cos(x[2] * p[1]))
    b = ca.fmin(a, x[2]) + ca.if_else(x[0] > 0, a * a, -a)
    parameter_only = p[0] * p[1] + 3
    return ca.Function("f", [x, p], [ca.vertcat(a, parameter_only, b, 0, 7), x[1] - x[0]])


@pytest.mark.parametrize("count", [1, WORTHWHILE - 1, WORTHWHILE, 23])
def test_agrees_with_one_stage_at_a_time(count):
    function = deep_function()
    x, p = ca.MX.sym("x", 3, count), ca.MX.sym("p", 2)
    evaluated = ca.Function("b", [x, p], batched(function, count, x, p))
    values = np.random.default_rng(count).normal(size=(3, count))
    parameters = np.array([0.7, -1.3])
    results = [np.array(r) for r in evaluated(values, parameters)]
    for k in range(count):
        for result, expected in zip(results, function(values[:, k], parameters), strict=True):
            np.testing.assert_allclose(result[:, k], np.array(expected).ravel(), rtol=1e-15)
