import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from llsrbm.analysis.inertia_ellipsoid import ellipsoid
from llsrbm.robots import load_robot


def solid_inertia(axes, wxyz, mass):
    """Inertia of a uniform solid ellipsoid, from points drawn on a grid inside it."""
    R = Rotation.from_quat(wxyz, scalar_first=True).as_matrix()
    grid = np.linspace(-1, 1, 61)
    ball = np.stack(np.meshgrid(grid, grid, grid), axis=-1).reshape(-1, 3)
    points = (ball[np.linalg.norm(ball, axis=1) <= 1] * axes) @ R.T
    second = points.T @ points / len(points)
    return mass * (np.trace(second) * np.eye(3) - second)


def test_the_ellipsoid_has_the_inertia_it_is_drawn_for():
    robot = load_robot("anymal")
    turn = Rotation.from_euler("zyx", [0.7, 0.2, -0.4]).as_matrix()
    inertia = turn @ robot.inertia @ turn.T
    axes, wxyz = ellipsoid(inertia[None], robot.mass, turn[None])
    assert solid_inertia(axes[0], wxyz[0], robot.mass) == pytest.approx(inertia, rel=0.01, abs=0.01)


@given(arrays(float, 3, elements=st.floats(-3, 3)), st.permutations([0.9, 1.1, 1.3]))
def test_the_ellipsoid_turns_with_its_reference(rotation_vector, moments):
    """Axis i stays near the reference's axis i, whichever moment is the largest."""
    turn = Rotation.from_rotvec(rotation_vector)
    R = turn.as_matrix()
    _, wxyz = ellipsoid((R @ np.diag(moments) @ R.T)[None], 30.0, R[None])
    apart = turn.inv() * Rotation.from_quat(wxyz[0], scalar_first=True)
    assert apart.magnitude() < 1e-6
