"""Against SciPy's rotations."""

import casadi as ca
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from llsrbm.planning.problem.rotations import quat_exp, quat_product, rotation_matrix

quickly = settings(max_examples=50, deadline=None)
seeds = st.integers(0, 2**31)


def random_quat(rng):
    return Rotation.random(random_state=rng).as_quat(scalar_first=True)


@quickly
@given(seed=seeds)
def test_matrix(seed):
    quat = random_quat(np.random.default_rng(seed))
    expected = Rotation.from_quat(quat, scalar_first=True).as_matrix()
    np.testing.assert_allclose(np.array(rotation_matrix(ca.DM(quat))), expected, atol=1e-12)


@quickly
@given(seed=seeds)
def test_product(seed):
    rng = np.random.default_rng(seed)
    a, b = random_quat(rng), random_quat(rng)
    product = np.array(quat_product(ca.DM(a), ca.DM(b))).ravel()
    one, two = (Rotation.from_quat(q, scalar_first=True) for q in (a, b))
    np.testing.assert_allclose(rotation_matrix(ca.DM(product)), (one * two).as_matrix(), atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(product), 1.0, atol=1e-14)


@quickly
@given(st.tuples(*[st.floats(-0.288, 0.288)] * 3))
def test_exponential_below_half_a_radian(vector):
    exact = Rotation.from_rotvec(vector).as_quat(scalar_first=True)
    np.testing.assert_allclose(np.array(quat_exp(ca.DM(vector))).ravel(), exact, atol=1e-9)


def test_exponential_of_nothing_has_a_derivative():
    v = ca.SX.sym("v", 3)
    slope = ca.Function("f", [v], [ca.jacobian(quat_exp(v), v)])(ca.DM.zeros(3))
    np.testing.assert_array_equal(np.array(slope), np.vstack([np.zeros(3), np.eye(3) / 2]))
