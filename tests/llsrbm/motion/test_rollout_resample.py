"""A rollout between its ticks."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from llsrbm.motion.sampling import resample, with_events
from tests.llsrbm.synthetic_rollout import RATE, synthetic_rollout

TICK = 1 / RATE


@pytest.fixture(scope="module")
def rollout():
    return synthetic_rollout()


def test_ticks_are_reproduced_exactly(rollout):
    back = resample(rollout, rollout.time)
    for field in fields(rollout):
        value = getattr(rollout, field.name)
        if isinstance(value, np.ndarray):
            tolerance = 1e-15 if "quat" in field.name or field.name == "qpos" else 0
            np.testing.assert_allclose(
                getattr(back, field.name), value, rtol=0, atol=tolerance, err_msg=field.name
            )
            assert getattr(back, field.name).dtype == value.dtype


@settings(deadline=None)
@given(share=st.floats(0.01, 0.99), tick=st.integers(0, 999))
def test_between_ticks(rollout, share, tick):
    at = resample(rollout, [rollout.time[tick] + share * TICK])
    for name in ("torque", "contact_force", "contact", "mode", "phase", "detection_signal"):
        np.testing.assert_array_equal(getattr(at, name)[0], getattr(rollout, name)[tick])
    for name in ("com", "foot_position", "angular_momentum", "qvel"):
        a, b = getattr(rollout, name)[tick : tick + 2]
        np.testing.assert_allclose(getattr(at, name)[0], a + share * (b - a), atol=1e-9)
    for ticks, got in (
        (rollout.base_quat, at.base_quat),
        (rollout.reference_base_quat, at.reference_base_quat),
        (rollout.qpos[:, 3:7], at.qpos[:, 3:7]),
    ):
        start, end = Rotation.from_quat(ticks[tick : tick + 2], scalar_first=True)
        here = Rotation.from_quat(got[0], scalar_first=True)
        turned = (start.inv() * here).as_rotvec()
        np.testing.assert_allclose(turned, share * (start.inv() * end).as_rotvec(), atol=1e-9)


def test_a_flip_of_a_quaternions_sign_is_no_turn(rollout):
    sign = np.where(np.arange(len(rollout.time)) % 2, -1.0, 1.0)[:, None]
    qpos = rollout.qpos.copy()
    qpos[:, 3:7] *= sign
    flipped = replace(rollout, base_quat=rollout.base_quat * sign, qpos=qpos)
    times = np.linspace(0, 2.5, 333)
    expected, got = resample(rollout, times), resample(flipped, times)
    np.testing.assert_allclose(got.base_quat, expected.base_quat, atol=1e-12)
    np.testing.assert_allclose(got.qpos, expected.qpos, atol=1e-12)


@pytest.mark.parametrize("fps", [7.0, 60.0, 400.0, 1000.0])
def test_frames_and_events(rollout, fps):
    times = with_events(rollout, fps)
    assert (times[0], times[-1]) == (rollout.time[0], rollout.time[-1])
    assert (np.diff(times) > 1e-9).all()
    assert np.diff(times).max() < 1 / fps + 1e-9
    even = np.arange(int(2.5 * fps) + 1) / fps
    assert np.abs(times[:, None] - even).min(axis=0).max() < 1e-9
    outcome = rollout.outcome
    for event in (outcome.touchdown_true_s, outcome.touchdown_detected_s):
        assert np.abs(times - event).min() < 1e-9
