"""A rollout's native file: what goes in comes out, and anything else is one clear line."""

import json
from dataclasses import replace

import numpy as np
import pytest

from llsrbm.errors import Error, FileFormatError
from llsrbm.files.quantity import quantities
from llsrbm.motion.plan import Plan, load_plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.trajectory import load
from tests.llsrbm.native_files import message, rewritten
from tests.llsrbm.sameness import assert_same
from tests.llsrbm.synthetic import TWO_HOPS, TWO_HOPS_DURATIONS, synthetic_plan
from tests.llsrbm.synthetic_rollout import followed, synthetic_rollout

LAYOUT = quantities(Rollout)


@pytest.fixture(scope="module")
def rollout():
    return synthetic_rollout(seed=3)


@pytest.fixture
def saved(rollout, tmp_path):
    path = tmp_path / "rollout.npz"
    rollout.save(path)
    return path


def test_round_trip(rollout, saved):
    assert_same(rollout, load(saved))


def test_the_plan_that_was_followed(rollout, saved, tmp_path):
    assert_same(rollout.plan, load(saved).plan)
    with np.load(saved) as archive:
        np.testing.assert_array_equal(archive["plan/com"], rollout.plan.com)
    bent = rewritten(saved, tmp_path / "x.npz", **{"plan/com": rollout.plan.com[:-1]})
    assert 'plan/: key "com": expected shape (T, 3)' in message(bent)


def test_round_trip_of_another_schedule(tmp_path):
    rollout = followed(synthetic_plan(schedule=TWO_HOPS, durations=TWO_HOPS_DURATIONS))
    rollout.save(tmp_path / "hops.npz")
    back = load(tmp_path / "hops.npz")
    assert_same(rollout, back)
    assert back.schedule == TWO_HOPS
    for phase in (7, -1):
        path = rewritten(
            tmp_path / "hops.npz", tmp_path / "x.npz", phase=np.full(len(rollout.time), phase)
        )
        assert 'key "phase": expected 0 (take-off), 1 (rear push), 2 (flight), ' in message(path)


def test_layout_is_the_contracts(rollout, saved):
    """Read with NumPy alone, as somebody else's script would."""
    T, L, J = len(rollout.time), 4, 12
    expected = {
        "schema": (), "meta": (), "time": (T,), "qpos": (T, 7 + J), "qvel": (T, 6 + J),
        "joint_names": (J,), "torque": (T, J), "torque_limit": (T, J), "com": (T, 3),
        "base_quat": (T, 4), "base_position": (T, 3), "linear_momentum": (T, 3),
        "angular_momentum": (T, 3), "inertia": (T, 3, 3), "foot_position": (T, L, 3),
        "contact": (T, L), "contact_force": (T, L, 3), "average_spatial_velocity_norm": (T,),
        "mode": (T,), "phase": (T,), "reference_com": (T, 3), "reference_base_quat": (T, 4),
        "reference_foot_position": (T, L, 3), "reference_angular_momentum": (T, 3),
    }  # fmt: skip
    with np.load(saved, allow_pickle=False) as archive:
        assert {key: archive[key].shape for key in expected} == expected
        assert archive["schema"] == "llsrbm.rollout/1"
        own = [key for key in archive if not key.startswith("plan/")]
        whole = {key for key in own if archive[key].dtype.kind == "i"}
        assert whole == {"contact", "mode", "phase"}
        meta = json.loads(str(archive["meta"]), parse_constant=pytest.fail)
    assert meta["request"]["twist"] == rollout.jump.twist
    assert meta["model"] == "llsrbm-plus"
    assert meta["robot_parameters"]["mass"] == 30.0
    assert meta["scenario"]["seed"] == 3
    assert meta["disturbance"]["friction"] == rollout.disturbance.friction
    assert meta["outcome"]["status"] == "landed"
    assert meta["package_version"]


def test_a_rollout_that_is_not_finite_is_not_written(rollout, tmp_path):
    torque = rollout.torque.copy()
    torque[3, 1] = np.inf
    with pytest.raises(Error, match=r"rollout\.torque holds numbers that are not finite"):
        replace(rollout, torque=torque).save(tmp_path / "rollout.npz")
    assert not list(tmp_path.iterdir())


class TestReading:
    def test_plans_and_rollouts_are_told_apart(self, rollout, saved, tmp_path):
        synthetic_plan().save(tmp_path / "plan.npz")
        assert isinstance(load(tmp_path / "plan.npz"), Plan)
        with pytest.raises(FileFormatError, match=r'"llsrbm.rollout/1"; expected "llsrbm.plan/2"'):
            load_plan(saved)

    def test_wrong_shapes(self, rollout, saved, tmp_path):
        for key in LAYOUT:
            value = np.asarray(getattr(rollout, key))
            path = rewritten(saved, tmp_path / "x.npz", **{key: value[None]})
            assert f'key "{key}": expected shape' in message(path)

    @pytest.mark.parametrize(("key", "base"), [("qpos", 7), ("qvel", 6)])
    def test_states_of_another_number_of_joints(self, rollout, saved, tmp_path, key, base):
        fewer = getattr(rollout, key)[:, :-1]
        path = rewritten(saved, tmp_path / "x.npz", **{key: fewer})
        said = f'key "{key}": expected {base} + 12 columns, one a joint, got {base + 11}'
        assert said in message(path)

    def test_values_that_make_no_rollout(self, rollout, saved, tmp_path):
        for key, value, said in (
            ("time", rollout.time[::-1], "strictly increasing"),
            ("phase", rollout.phase + 1, "0 (take-off)"),
            ("mode", rollout.mode - 1, "0 (tracking)"),
            ("contact", 2 * rollout.contact, "0 (in the air), 1 (touches)"),
            ("contact", rollout.contact.astype(float), "expected integers"),
            ("base_quat", 2 * rollout.base_quat, "unit quaternions w, x, y, z"),
            ("reference_base_quat", 0 * rollout.base_quat, "unit quaternions w, x, y, z"),
            ("com", np.full_like(rollout.com, np.nan), "expected finite numbers"),
        ):
            text = message(rewritten(saved, tmp_path / "x.npz", **{key: value}))
            assert f'key "{key}"' in text
            assert said in text

    @pytest.mark.parametrize(
        ("path", "value", "said"),
        [
            (("request", "twist"), "abc", "request.twist"),
            (("outcome", "status"), None, "outcome.status"),
            (("disturbance", "friction"), "slippery", "disturbance.friction"),
            (("scenario", "seed"), 1.5, "scenario.seed"),
            (("scenario", "noise"), 4.0, "noise: expected 0 to 3, got 4"),
            (("scenario", "pushes"), [{"time": 1}], "scenario.pushes.0.impulse"),
            (
                ("scenario", "pushes"),
                [{"time": 0.4, "impulse": [0, 1e6, 0]}],
                "push: impulse: expected at most 200 N s, got 1e+06 N s",
            ),
            (("request", "twist"), "NaN", "twist: expected a finite number"),
        ],
    )
    def test_meta_that_is_wrong(self, saved, tmp_path, path, value, said):
        with np.load(saved) as archive:
            meta = json.loads(str(archive["meta"]))
        meta[path[0]][path[1]] = value
        text = message(rewritten(saved, tmp_path / "x.npz", meta=np.array(json.dumps(meta))))
        assert f'key "meta": {said}' in text
