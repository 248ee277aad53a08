"""Random quadratic programs with a known feasible point, and the optimality conditions of one."""

import numpy as np
from hypothesis import strategies as st
from scipy.optimize import nnls

from llsrbm.control.qp import Qp


def program(seed, variables=12, equalities=3, inequalities=16):
    """A program with feasible points around `inside`, as near to some limits as 0.02."""
    rng = np.random.default_rng(seed)
    p = Qp.zeros(variables, equalities, inequalities)
    root = rng.normal(size=(variables, variables)) * 10 ** rng.uniform(-1, 1, variables)
    p.H[:] = root.T @ root / variables + 1e-2 * np.eye(variables)
    p.g[:] = 10 * rng.normal(size=variables)
    inside = rng.normal(size=variables)
    p.A[:] = rng.normal(size=(equalities, variables))
    p.b[:] = p.A @ inside
    p.C[:] = rng.normal(size=(inequalities, variables))
    room = rng.choice([0.02, 0.1, 1.0, np.inf], size=(2, inequalities))
    p.lower[:], p.upper[:] = p.C @ inside - room[0], p.C @ inside + room[1]
    return p


def programs():
    return st.builds(
        program,
        seed=st.integers(0, 2**32 - 1),
        equalities=st.integers(0, 5),
        inequalities=st.integers(0, 20),
    )


def violation(p, x):
    """How far x is from satisfying the constraints, largest first."""
    return max(
        np.abs(p.A @ x - p.b).max(initial=0),
        (p.lower - p.C @ x).max(initial=0),
        (p.C @ x - p.upper).max(initial=0),
    )


def stationarity(p, x, active=1e-4):
    """What of the gradient no admissible multipliers of the constraints that are active explain."""
    values = p.C @ x
    columns = [*p.A, *-p.A, *p.C[values - p.lower < active], *-p.C[p.upper - values < active]]
    gradient = p.H @ x + p.g
    return nnls(np.array(columns).T, gradient)[1] if columns else np.linalg.norm(gradient)
