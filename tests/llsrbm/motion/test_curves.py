"""Curves between knots against differences and SciPy's rotations."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from llsrbm.motion.curves import Polynomials, Turns

RNG = np.random.default_rng(5)
DT = np.array([0.1, 0.3, 0.2])
STEP = 1e-6


def both_sides(curve, k, share):
    """Slope by differences, per s, within intervals."""
    ahead, behind = curve(k, share + STEP), curve(k, share - STEP)
    return ahead, behind, 2 * STEP * DT[k]


def test_cubics_meet_values_and_slopes():
    values, slopes = RNG.normal(size=(2, 4, 2))
    curve = Polynomials.cubics(values, slopes, DT)
    k = np.arange(3)
    for share, side in ((np.zeros(3), slice(0, 3)), (np.ones(3), slice(1, 4))):
        np.testing.assert_allclose(curve.at(k, share), values[side], atol=1e-12)
        np.testing.assert_allclose(curve.slopes(k, share), slopes[side], atol=1e-12)
    share = np.array([0.2, 0.5, 0.9])
    ahead, behind, apart = both_sides(curve.at, k, share)
    slope = (ahead - behind) / apart[:, None]
    np.testing.assert_allclose(curve.slopes(k, share), slope, atol=1e-6)
    twice = curve + curve
    np.testing.assert_allclose(twice.at(k, share), 2 * curve.at(k, share))


@pytest.mark.parametrize("size", [1e-5, 0.2, 1.5])
def test_turns_meet_attitudes_and_rates(size):
    steps = Rotation.from_rotvec(size * RNG.normal(size=(4, 3)))
    known = [steps[0]]
    for step in steps[1:]:
        known.append(known[-1] * step)
    quat = np.array([each.as_quat(scalar_first=True) for each in known])
    rate = size * RNG.normal(size=(4, 3))
    curve = Turns.through(quat, rate, DT)
    k = np.arange(3)

    def rotation(k, share):
        return Rotation.from_quat(curve.at(k, share)[0], scalar_first=True)

    for share, side in ((np.zeros(3), slice(0, 3)), (np.ones(3), slice(1, 4))):
        truth = Rotation.from_quat(quat[side], scalar_first=True)
        assert (rotation(k, share).inv() * truth).magnitude().max() < 1e-9
        np.testing.assert_allclose(curve.at(k, share)[1], rate[side], rtol=1e-6, atol=1e-12)
    share = np.array([0.3, 0.5, 0.8])
    ahead, behind, apart = both_sides(rotation, k, share)
    turned = (behind.inv() * ahead).as_rotvec() / apart[:, None]
    np.testing.assert_allclose(curve.at(k, share)[1], turned, rtol=1e-5, atol=1e-7)
