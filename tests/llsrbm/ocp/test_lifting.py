"""Derivatives through marked intermediates are those of the expression written out."""

import casadi as ca
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from llsrbm.ocp.lifting import Lifting

OPERATIONS = {
    "sum": lambda a, b: a + 2 * b,
    "product": lambda a, b: a * b,
    "sine": lambda a, b: ca.sin(a) - b,
    "quotient": lambda a, b: a / (2 + b**2),
    "cross": ca.cross,
    "scaled": lambda a, b: a * ca.dot(a, b),
    "matrix": lambda a, b: ca.mtimes(ca.horzcat(a, b, a - b), b),
    "constant": lambda a, b: ca.SX([1.0, 2.0, 3.0]),
}
VARIABLES = 6

# Each step combines two earlier vectors and may be marked.
graphs = st.lists(
    st.tuples(
        st.sampled_from(sorted(OPERATIONS)), st.integers(0, 100), st.integers(0, 100), st.booleans()
    ),
    min_size=1,
    max_size=7,
)
points = st.lists(st.floats(-1, 1), min_size=VARIABLES, max_size=VARIABLES)


def build(graph, z, lift):
    nodes = [z[:3], z[3:]]
    for operation, i, j, marked in graph:
        node = OPERATIONS[operation](nodes[i % len(nodes)], nodes[j % len(nodes)])
        nodes.append(lift(node) if marked else node)
    return nodes


def numbers(z, expression, point):
    return np.array(ca.Function("f", [z], [ca.densify(expression)])(point))


@settings(max_examples=120, deadline=None)
@given(graph=graphs, point=points)
def test_random_graphs(graph, point):
    z = ca.SX.sym("z", VARIABLES)
    lift = Lifting(z)
    through, plain = build(graph, z, lift), build(graph, z, lambda e: e)
    for outputs, direct in (
        (ca.vertcat(*through[-2:]), ca.vertcat(*plain[-2:])),
        (ca.vertcat(*through), ca.vertcat(*plain)),
    ):
        np.testing.assert_allclose(
            numbers(z, lift.resolve(outputs), point), numbers(z, direct, point), atol=1e-12
        )
        np.testing.assert_allclose(
            numbers(z, lift.resolve(lift.jacobian(outputs)), point),
            numbers(z, ca.jacobian(direct, z), point),
            atol=1e-9,
        )
    scalar, direct = (ca.sumsqr(nodes[-1]) + ca.sum1(nodes[-2]) for nodes in (through, plain))
    np.testing.assert_allclose(
        numbers(z, lift.resolve(lift.hessian(scalar)), point),
        numbers(z, ca.hessian(direct, z)[0], point),
        atol=1e-8,
    )


def test_parameters_are_no_variables():
    z, p = ca.SX.sym("z", 2), ca.SX.sym("p")
    lift = Lifting(z)
    y = lift(p * z[0])
    assert lift.jacobian(y * z[1]).shape == (1, 2)
    assert lift.hessian(y * z[1]).shape == (2, 2)
    value = ca.Function("f", [z, p], [lift.resolve(lift.hessian(y * z[1]))])([5, 7], 3)
    np.testing.assert_allclose(np.array(value), [[0, 3], [3, 0]])
