"""Replans in a rollout's file: what goes in comes out, and anything else is one clear line."""

from dataclasses import fields, replace

import numpy as np
import pytest

from llsrbm.errors import Error
from llsrbm.motion.replan import Replan
from llsrbm.motion.trajectory import load
from tests.llsrbm.native_files import message, rewritten
from tests.llsrbm.synthetic_rollout import synthetic_rollout

LEGS = 4


def replan(knots, seed=0, **changes):
    rng = np.random.default_rng(seed)
    quat = rng.normal(size=(knots, 1 + LEGS, 4))
    quat /= np.linalg.norm(quat, axis=-1, keepdims=True)
    made = Replan(
        measured=0.4 + seed / 50,
        applied=0.42 + seed / 50,
        computing_time=0.0123,
        solved=knots > 0,
        iterations=4 + seed,
        touchdown=0.7,
        time=0.4 + 0.01 * np.arange(knots),
        com=rng.normal(size=(knots, 3)),
        base_quat=quat[:, 0],
        foot_position=rng.normal(size=(knots, LEGS, 3)),
        foot_quat=quat[:, 1:],
    )
    return replace(made, **changes)


NOTHING = replan(0, 2, applied=np.nan, touchdown=np.nan)
REPLANS = (replan(5), NOTHING, replan(3, 3), replan(7, 4, applied=np.nan))


@pytest.fixture(scope="module")
def rollout():
    return synthetic_rollout(seed=3)


def assert_same_replans(a, b):
    assert len(a) == len(b)
    for one, other in zip(a, b, strict=True):
        for field in fields(Replan):
            x, y = getattr(one, field.name), getattr(other, field.name)
            assert type(x) is type(y), field.name
            np.testing.assert_array_equal(x, y, err_msg=field.name)
            assert np.shape(x) == np.shape(y)


@pytest.mark.parametrize(
    "replans", [(), REPLANS, REPLANS[:1], (NOTHING,), (NOTHING, NOTHING), (NOTHING, *REPLANS)]
)
def test_round_trip(rollout, replans, tmp_path):
    replace(rollout, replans=replans).save(tmp_path / "r.npz")
    assert_same_replans(load(tmp_path / "r.npz").replans, replans)


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("knots", [5, 0, 3, 6], 'key "knots": expected 15 in all, as "time" has'),
        ("knots", [-1, 1, 8, 7], 'key "knots": expected 15 in all'),
        ("knots", [2**62] * 4, 'key "knots": expected 15 in all'),
        ("knots", [5, 3, 7], 'key "knots": expected shape (R)'),
        ("solved", [1, 0, 2, 1], 'key "solved": expected 0 or 1'),
        ("asked", [0.1, np.nan, 0.2, 0.3], 'key "asked": expected finite numbers'),
        ("applied", None, 'key "applied" is missing'),
        ("com", None, 'key "com" is missing'),
        ("com", np.zeros((14, 3)), 'key "com": expected shape (T, 3)'),
        ("base_quat", np.ones((15, 4)), 'key "base_quat": expected unit quaternions'),
        ("foot_position", np.zeros((15, 2, 3)), "expected shape (T, L, 4) with L = 2"),
    ],
)
def test_what_is_no_replan(rollout, key, value, said, tmp_path):
    replace(rollout, replans=REPLANS).save(tmp_path / "r.npz")
    value = None if value is None else np.array(value)
    assert said in message(
        rewritten(tmp_path / "r.npz", tmp_path / "x.npz", **{f"replan/{key}": value})
    )


def test_feet_of_another_robot(rollout, tmp_path):
    replace(rollout, replans=REPLANS).save(tmp_path / "r.npz")
    feet = {
        "replan/foot_position": np.zeros((15, 2, 3)),
        "replan/foot_quat": np.tile([1.0, 0, 0, 0], (15, 2, 1)),
    }
    said = message(rewritten(tmp_path / "r.npz", tmp_path / "x.npz", **feet))
    assert 'replan/ key "foot_position": expected 4 feet' in said


def test_what_is_not_finite_is_not_written(rollout, tmp_path):
    bent = replan(5, com=np.full((5, 3), np.inf))
    with pytest.raises(Error, match="a replan's com holds numbers that are not finite"):
        replace(rollout, replans=(bent,)).save(tmp_path / "r.npz")
    assert not list(tmp_path.iterdir())
