import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from llsrbm.mechanics import cross, rotation_matrices, skew, tilt, yaw

ANGLES = st.floats(-1.2, 1.2)


@given(st.floats(-3.0, 3.0), ANGLES, ANGLES)
def test_heading_and_tilt_are_those_of_the_axes(heading, pitch, roll):
    attitude = Rotation.from_euler("ZYX", [heading, pitch, roll])
    quat = attitude.as_quat(scalar_first=True)[None]
    x, z = attitude.apply([1.0, 0.0, 0.0]), attitude.apply([0.0, 0.0, 1.0])
    assert yaw(quat)[0] == pytest.approx(np.arctan2(x[1], x[0]), abs=1e-9)
    assert np.cos(tilt(quat)[0]) == pytest.approx(z[2], abs=1e-9)


def test_a_full_turn_keeps_counting():
    turn = np.linspace(0.0, 2 * np.pi, 50)
    quat = Rotation.from_euler("z", turn[:, None]).as_quat(scalar_first=True)
    np.testing.assert_allclose(yaw(quat), turn, atol=1e-9)
    np.testing.assert_allclose(tilt(quat), 0.0, atol=1e-9)


vectors = arrays(float, (3,), elements=st.floats(-10, 10))


@given(a=vectors, b=vectors)
def test_vector_algebra(a, b):
    np.testing.assert_allclose(cross(a, b), np.cross(a, b), atol=1e-12)
    np.testing.assert_allclose(skew(a) @ b, np.cross(a, b), atol=1e-12)


@given(turn=vectors)
def test_quaternions_are_w_x_y_z(turn):
    quat = pin.Quaternion(pin.exp3(turn)).coeffs()
    np.testing.assert_allclose(rotation_matrices(quat[[3, 0, 1, 2]]), pin.exp3(turn), atol=1e-12)
