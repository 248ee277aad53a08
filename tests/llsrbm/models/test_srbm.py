import numpy as np

from llsrbm.models.llsrbm import SRBM
from tests.llsrbm.models.postures import (
    LEGS,
    ROBOT,
    evaluate,
    evaluate_momentum,
)

MODEL = SRBM(ROBOT)


def test_constant_wherever_the_feet_are():
    rng = np.random.default_rng(0)
    x = rng.uniform(-0.5, 0.5, size=(20, LEGS, 3))
    offset, inertia, leg_com = evaluate(MODEL, x)
    np.testing.assert_allclose(inertia, np.broadcast_to(ROBOT.inertia, (20, 3, 3)), atol=1e-14)
    expected = np.broadcast_to(ROBOT.base_position - ROBOT.com, (20, 3))
    np.testing.assert_allclose(offset, expected, atol=1e-14)
    # Massless legs: all that is left to show is the foot.
    np.testing.assert_allclose(leg_com, offset[:, None] + MODEL.hips + MODEL.mirrors * x)
    assert (MODEL.leg_mass == 0).all()
    assert MODEL.base_mass == MODEL.mass


def test_momentum_is_inertia_times_rate():
    rng = np.random.default_rng(1)
    (x, xdot), w = rng.normal(size=(2, 9, LEGS, 3)), rng.normal(size=(9, 3))
    np.testing.assert_allclose(
        evaluate_momentum(MODEL, x, xdot, w), w @ ROBOT.inertia.T, atol=1e-13
    )
