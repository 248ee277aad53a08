"""Derivatives through marked intermediates are those of the expression written out."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from llsrbm.ocp.derivatives import Derivatives
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


def functions(z, lift, numbers, outputs, symbolic):
    """Values, slopes and curvature of the outputs' sum, of MX or of SX."""
    found = Derivatives("f", lift, numbers, outputs)
    arguments = [symbolic.sym(f"a{k}", x.numel()) for k, x in enumerate([z, *numbers])]
    values, J = found.jacobian(*arguments)
    H = found.hessian(*arguments, symbolic.ones(outputs.shape[0], 1))
    return ca.Function("found", arguments, [values, ca.densify(J), ca.densify(H)])


@settings(max_examples=40, deadline=None)
@given(graph=graphs, point=points, symbolic=st.sampled_from([ca.MX, ca.SX]))
def test_random_graphs(graph, point, symbolic):
    z = ca.SX.sym("z", VARIABLES)
    lift = Lifting(z)
    through, plain = (ca.vertcat(*build(graph, z, mark)) for mark in (lift, lambda e: e))
    found = functions(z, lift, [], through, symbolic)(point)
    direct = [plain, ca.jacobian(plain, z), ca.hessian(ca.sum1(plain), z)[0]]
    expected = ca.Function("expected", [z], [ca.densify(each) for each in direct])(point)
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(np.array(one), np.array(other), atol=1e-8)
    resolved = ca.Function("resolved", [z], [ca.densify(lift.resolve(through))])(point)
    np.testing.assert_allclose(np.array(resolved), np.array(expected[0]), atol=1e-12)


@pytest.mark.parametrize("symbolic", [ca.MX, ca.SX])
def test_parameters_are_no_variables(symbolic):
    z, p = ca.SX.sym("z", 2), ca.SX.sym("p")
    lift = Lifting(z)
    y = lift(p * z[0])
    values, J, H = functions(z, lift, [p], y * z[1], symbolic)([5, 7], 3)
    assert float(values) == 105
    np.testing.assert_allclose(np.array(J), [[21, 15]])
    np.testing.assert_allclose(np.array(H), [[0, 3], [3, 0]])
