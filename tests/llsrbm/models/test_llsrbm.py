"""The paper's model against the paper's equations, written out in NumPy."""

import numpy as np
from hypothesis import given, settings

from llsrbm.models.llsrbm import LLSRBM
from tests.llsrbm.models.postures import (
    LEGS,
    ROBOT,
    evaluate,
    evaluate_momentum,
    feet_in_reach,
    feet_of,
    standing_feet_in_hip,
)

MODEL = LLSRBM(ROBOT)
FRACTION, LEG_MASS = ROBOT.fit.proportional_fraction, ROBOT.fit.proportional_mass


def parallel_axis(d):
    return d @ d * np.eye(3) - np.outer(d, d)


def lumps(hips, feet):
    """Point masses on the line from foot to hip (the paper's dp_i is s of that vector)."""
    return feet + FRACTION * (hips - feet)


def test_agrees_with_the_urdf_in_the_default_posture():
    offset, inertia, _ = evaluate(MODEL, standing_feet_in_hip()[None])
    np.testing.assert_allclose(inertia[0], ROBOT.inertia, atol=1e-12)
    np.testing.assert_allclose(offset[0], ROBOT.base_position - ROBOT.com, atol=1e-13)
    seen = feet_of(MODEL, (ROBOT.feet - ROBOT.com)[None])[0]
    np.testing.assert_allclose(seen, standing_feet_in_hip(), atol=1e-12)


@settings(max_examples=15, deadline=None)
@given(x=feet_in_reach())
def test_body_and_point_masses_make_the_inertia_and_the_com(x):
    """Equations 3, 5 and 6 in the base frame, the base's own body taken from the URDF's whole."""
    hips, feet = ROBOT.hips, ROBOT.hips + ROBOT.mirrors * x
    standing = ROBOT.feet - ROBOT.base_position
    com_standing = ROBOT.com - ROBOT.base_position
    base_mass = ROBOT.mass - LEGS * LEG_MASS
    base_com = (ROBOT.mass * com_standing - LEG_MASS * lumps(hips, standing).sum(axis=0)) / (
        base_mass
    )
    # The base's inertia about the base's own CoM.
    base_inertia = ROBOT.inertia - base_mass * parallel_axis(base_com - com_standing)
    for d in lumps(hips, standing) - com_standing:
        base_inertia = base_inertia - LEG_MASS * parallel_axis(d)

    points = lumps(hips, feet)
    com = (base_mass * base_com + LEG_MASS * points.sum(axis=0)) / ROBOT.mass
    expected = base_inertia + base_mass * parallel_axis(base_com - com)
    for d in points - com:
        expected = expected + LEG_MASS * parallel_axis(d)

    offset, inertia, leg_com = evaluate(MODEL, x[None])
    np.testing.assert_allclose(offset[0], -com, atol=1e-13)
    np.testing.assert_allclose(inertia[0], expected, atol=1e-12)
    np.testing.assert_allclose(leg_com[0], points - com, atol=1e-13)
    assert np.linalg.eigvalsh(base_inertia).min() > 0


def test_legs_carry_no_momentum():
    rng = np.random.default_rng(2)
    x, xdot, w = rng.normal(size=(3, LEGS, 3)), rng.normal(size=(3, LEGS, 3)), np.zeros((3, 3))
    np.testing.assert_array_equal(evaluate_momentum(MODEL, x, xdot, w), 0.0)
