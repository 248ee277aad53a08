"""The solver's functions against CasADi's own derivatives and against differences."""

from functools import cache

import casadi as ca
import numpy as np
import pytest

from llsrbm.planning.problem.jump_horizon import constraints_of, row_bounds
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.solve.jump_layout import layout_of
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.llsrbm.planning.solved import function, parameters, solved

every_model = pytest.mark.parametrize("model", ["srbm", "llsrbm-plus"])


@cache
def near_a_solution(model):
    """A point a little off a plan, random multipliers and directions."""
    s = solved(model, "all")
    rng = np.random.default_rng(0)
    w = s.w + rng.normal(scale=0.02, size=s.w.size)
    lam = rng.normal(size=function(s.planner, "nlp").size1_out(1))
    return s, w, parameters(s.planner.layout, s.task), 0.7, lam, rng.normal(size=(3, w.size))


@cache
def differentiated(model):
    """Gradient of lam_f f + lam g, J v and H v by CasADi's differentiation of the oracle."""
    nlp = function(solved(model, "all").planner, "nlp")
    x, p = (ca.MX.sym(n, nlp.size1_in(i)) for i, n in enumerate("xp"))
    lam_f, lam, v = (
        ca.MX.sym("lam_f"),
        ca.MX.sym("lam", nlp.size1_out(1)),
        ca.MX.sym("v", x.numel()),
    )
    f, g = nlp(x, p)
    slope = ca.gradient(lam_f * f + ca.dot(lam, g), x)
    results = [ca.gradient(f, x), slope, ca.jtimes(g, x, v), ca.jtimes(slope, x, v)]
    return ca.Function("ad", [x, p, lam_f, lam, v], results)


@every_model
def test_second_derivatives(model):
    s, w, p, lam_f, lam, directions = near_a_solution(model)
    _, H = function(s.planner, "nlp_hess_l")(w, p, lam_f, lam)
    np.testing.assert_allclose(np.array(H), np.array(H).T, atol=1e-10)
    for v in directions:
        Hv = np.array(differentiated(model)(w, p, lam_f, lam, v)[3]).ravel()
        np.testing.assert_allclose(np.array(ca.mtimes(H, v)).ravel(), Hv, rtol=1e-9, atol=1e-7)


@every_model
def test_differences_agree_too(model):
    """Not by CasADi at all: central differences of the functions' values."""
    s, w, p, _, _, directions = near_a_solution(model)
    nlp, v, step = function(s.planner, "nlp"), directions[0], 1e-5
    (f1, g1), (f0, g0) = (nlp(w + sign * step * v, p) for sign in (1, -1))
    J = function(s.planner, "nlp_jac_g")(w, p)[1]
    slope = np.array(g1 - g0).ravel() / (2 * step)
    np.testing.assert_allclose(np.array(ca.mtimes(J, v)).ravel(), slope, rtol=1e-5, atol=1e-5)
    grad_f = np.array(function(s.planner, "nlp_grad_f")(w, p)).ravel()
    assert grad_f @ v == pytest.approx(float(f1 - f0) / (2 * step), rel=1e-5)


@every_model
def test_a_plan_lies_within_the_rows_bounds(model):
    s = solved(model, "all")
    g = np.array(function(s.planner, "nlp_g")(s.w, parameters(s.planner.layout, s.task))).ravel()
    lower, upper = row_bounds(s.planner.layout, s.task)
    assert len(g) == len(lower) == len(upper)
    # 1e-4 is the solvers' tolerance.
    assert (g >= lower - 1e-4).all()
    assert (g <= upper + 1e-4).all()


@pytest.mark.parametrize(("robot", "kind"), [("anymal", "hops"), ("slider", "together")])
def test_bounds_of_a_role_are_the_same_at_its_knots_unless_said_otherwise(robot, kind):
    jump = Jump(robot=robot, type=kind, forward=0.2, height=0.1)
    task, layout = make_task(jump, load_robot(robot)), layout_of(jump, load_robot(robot))
    differ = set()
    for role, knots in layout.blocks():
        for constraint in constraints_of(role):
            first, *others = (constraint.bounds(task, layout, knot) for knot in knots)
            if any(not np.array_equal(first, other) for other in others):
                differ.add(constraint)
    assert differ
    assert all(constraint.by_knot for constraint in differ)
