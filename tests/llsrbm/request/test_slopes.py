"""Slopes as gradients, normals and axes of surfaces."""

import math

import casadi as ca
import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from llsrbm.mechanics import rotation_matrices, turns_about_z
from llsrbm.planning.problem.rotations import on_surface
from llsrbm.request.jump import Jump
from llsrbm.request.route import Landing
from llsrbm.request.slopes import gradient, gradients, leaning, normals, surface_axes

ANGLES = st.floats(-0.5, 0.5)


def test_a_surface_rises_ahead_and_to_the_left():
    for heading in (0.0, 0.7, -2.0):
        ahead, left = turns_about_z(heading)[:2, :2].T
        rises = gradient(0.2, 0.1, heading)
        assert math.isclose(rises @ ahead, math.tan(0.2))
        assert math.isclose(rises @ left, math.tan(0.1))


@given(ANGLES, ANGLES, st.floats(-3, 3))
def test_what_is_level_is_turned_onto_it(slope, cross_slope, heading):
    rises = gradient(slope, cross_slope, heading)
    normal = normals(rises)
    R = rotation_matrices(leaning(rises))
    np.testing.assert_allclose(R[:, 2], normal, atol=1e-9)
    along = np.array([1.0, 0.0, rises[0]]), np.array([0.0, 1.0, rises[1]])
    assert max(abs(normal @ each) for each in along) < 1e-9


@given(ANGLES, ANGLES)
def test_the_pyramids_edge_is_along_the_fall_line(slope, cross_slope):
    rises = gradient(slope, cross_slope, 0.0)
    # At a millionth, from which on a surface is not level, rounding decides.
    assume(not math.isclose(np.linalg.norm(rises), 1e-6, rel_tol=1e-6))
    axes = surface_axes(normals(rises))
    np.testing.assert_allclose(axes, ca.DM(on_surface(ca.DM(rises))).full(), atol=1e-9)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-9)
    if np.linalg.norm(rises) > 1e-5:
        gravity = axes.T @ [0.0, 0.0, -1.0]
        assert math.isclose(gravity[0], gravity[1], abs_tol=1e-9)


def test_level_ground_has_the_worlds_axes():
    assert (surface_axes(np.array([0.0, 0.0, 1.0])) == np.eye(3)).all()
    assert (ca.DM(on_surface(ca.DM.zeros(2))).full() == np.eye(3)).all()


def test_each_place_has_its_own():
    route = Landing(forward=0.1), Landing(forward=0.1, slope=0.3)
    start, first, second = gradients(Jump(takeoff_slope=0.1, route=route), 2, [0.0] * 3)
    assert not first.any()
    np.testing.assert_allclose(start, [math.tan(0.1), 0.0])
    np.testing.assert_allclose(second, [math.tan(0.3), 0.0])
