"""The native file: what goes in comes out, and anything else is one clear line."""

import json
import os
from dataclasses import replace

import numpy as np
import pytest

from llsrbm.errors import Error, InputError
from llsrbm.files.quantity import quantities
from llsrbm.motion.plan import OPTIONAL, Plan, load_plan
from llsrbm.motion.trajectory import load
from llsrbm.request.jump import Jump
from llsrbm.request.obstacle import Obstacle
from llsrbm.request.schedule import together
from tests.llsrbm.native_files import message, rewritten
from tests.llsrbm.sameness import assert_same
from tests.llsrbm.synthetic import LEGS, TWO_HOPS, TWO_HOPS_DURATIONS, synthetic_plan

LAYOUT = quantities(Plan)


@pytest.fixture(scope="module")
def plan():
    return synthetic_plan()


@pytest.fixture
def saved(plan, tmp_path):
    path = tmp_path / "plan.npz"
    plan.save(path)
    return path


def test_round_trip(plan, saved):
    assert_same(plan, load_plan(saved))
    assert_same(plan, load(saved))


def test_layout_is_the_contracts(plan, saved):
    """Read with NumPy alone, as somebody else's script would."""
    N, L, C, J = len(plan.time), 4, 4, 12
    expected = {
        "schema": (), "meta": (), "time": (N,), "phase": (N,), "com": (N, 3),
        "com_velocity": (N, 3), "base_quat": (N, 4), "base_position": (N, 3),
        "angular_velocity": (N, 3), "linear_momentum": (N, 3), "angular_momentum": (N, 3),
        "inertia": (N, 3, 3), "foot_position": (N, L, 3), "foot_quat": (N, L, 4),
        "contact_point": (N, C, 3), "contact_force": (N, C, 3), "leg_mass": (L,), "base_mass": (),
        "leg_com": (N, L, 3), "joint_position": (N, J), "joint_names": (J,),
        "joint_velocity": (N, J), "joint_torque": (N, J), "joint_torque_limit": (N, J),
    }  # fmt: skip
    with np.load(saved, allow_pickle=False) as archive:
        assert {key: archive[key].shape for key in expected} == expected
        assert archive["schema"] == "llsrbm.plan/2"
        meta = json.loads(str(archive["meta"]), parse_constant=pytest.fail)
    assert meta["request"]["twist"] == plan.jump.twist
    assert meta["model"] == "llsrbm-plus"
    assert meta["robot_parameters"]["mass"] == 30.0
    assert meta["report"]["solver"] == "fatrop"
    assert meta["violations"]["friction"]["amount"] == 2e-5
    assert meta["package_version"]


def with_meta(saved, path, **changes):
    """The file with some of what it says in JSON replaced, or left out where that is None."""
    with np.load(saved) as archive:
        meta = json.loads(str(archive["meta"])) | changes
    meta = {key: value for key, value in meta.items() if value is not None}
    return rewritten(saved, path, meta=np.array(json.dumps(meta)))


def test_round_trip_of_another_schedule(tmp_path):
    plan = synthetic_plan(schedule=TWO_HOPS, durations=TWO_HOPS_DURATIONS)
    plan.save(tmp_path / "plan.npz")
    back = load(tmp_path / "plan.npz")
    assert_same(plan, back)
    assert back.schedule == TWO_HOPS
    np.testing.assert_array_equal(back.contact, TWO_HOPS.stands[plan.phase])


def test_round_trip_of_an_obstacle(plan, saved, tmp_path):
    over = replace(plan, obstacle=Obstacle(0.4, 0.5, 0.12))
    over.save(tmp_path / "over.npz")
    assert_same(over, load(tmp_path / "over.npz"))
    assert load(saved).obstacle is None


@pytest.mark.parametrize(
    ("obstacle", "said"),
    [
        ({}, "obstacle: not one that this version wrote (KeyError('near')); expected near, far"),
        ({"near": 0, "far": 0.1, "height": None}, "obstacle: not one that this version wrote"),
        ({"near": 1e15, "far": 1e15 + 1, "height": 1}, "obstacle: it begins at 1e+15 m; expected"),
        ({"near": 0, "far": 0.1, "height": 9}, "obstacle: height 9 m; expected a hurdle of 0.01"),
    ],
)
def test_what_is_no_obstacle(saved, tmp_path, obstacle, said):
    assert f'key "meta": {said}' in message(with_meta(saved, tmp_path / "x.npz", obstacle=obstacle))


def test_a_type_that_is_a_path_is_not_opened(plan, tmp_path, monkeypatch):
    opened = []
    monkeypatch.setattr("llsrbm.request.jump_types._read", opened.append)
    path = tmp_path / "type.toml"
    path.write_text("no jump type")
    jump = replace(plan.jump, type=str(path))
    replace(plan, jump=jump).save(tmp_path / "plan.npz")
    back = load(tmp_path / "plan.npz")
    assert back.jump == jump
    assert back.schedule == plan.schedule
    assert not opened


def test_round_trip_without_loads(plan, tmp_path):
    """As of a plan that failed so badly that its motion has none."""
    none = dict.fromkeys(("joint_velocity", "joint_torque", "joint_torque_limit"))
    bare = replace(plan, **none)
    bare.save(tmp_path / "plan.npz")
    assert_same(bare, load(tmp_path / "plan.npz"))


def test_keys_added_by_later_versions_are_no_error(plan, saved, tmp_path):
    assert_same(plan, load(rewritten(saved, tmp_path / "new.npz", novelty=np.zeros(3))))


def test_a_plan_that_is_not_finite_is_not_written(plan, tmp_path):
    com = plan.com.copy()
    com[3, 1] = np.nan
    with pytest.raises(Error, match=r"plan\.com holds numbers that are not finite"):
        replace(plan, com=com).save(tmp_path / "plan.npz")
    assert not list(tmp_path.iterdir())


class TestReading:
    def test_pickled_objects_are_not_run(self, saved, tmp_path):
        class Bomb:
            def __reduce__(self):
                return (os.mkdir, (str(tmp_path / "exploded"),))

        path = rewritten(saved, tmp_path / "x.npz", com=np.array([Bomb()], dtype=object))
        assert "a pickle of Python objects, which is never opened" in message(path)
        assert not (tmp_path / "exploded").exists()

    def test_missing_keys(self, saved, tmp_path):
        for key in ("schema", "meta", *(key for key in LAYOUT if key not in OPTIONAL)):
            path = rewritten(saved, tmp_path / "x.npz", **{key: None})
            assert f'key "{key}" is missing' in message(path)

    def test_wrong_shapes(self, plan, saved, tmp_path):
        gain = np.zeros((len(plan.time), len(plan.joint_names), 1))
        for key in LAYOUT:
            value = gain if key in OPTIONAL else np.asarray(getattr(plan, key))
            path = rewritten(saved, tmp_path / "x.npz", **{key: value[None]})
            assert f'key "{key}": expected shape' in message(path)

    def test_sizes_that_contradict_each_other(self, plan, saved, tmp_path):
        path = rewritten(saved, tmp_path / "x.npz", com=plan.com[:-1])
        assert '(T, 3) with T = 49 as in "time", got (48, 3)' in message(path)

    @pytest.mark.parametrize("bad", [np.nan, np.inf])
    def test_not_finite(self, plan, saved, tmp_path, bad):
        com = plan.com.copy()
        com[3, 1] = bad
        path = rewritten(saved, tmp_path / "x.npz", com=com)
        assert f'key "com": expected finite numbers, got {bad} at (3, 1)' in message(path)

    def test_wrong_kinds(self, plan, saved, tmp_path):
        path = rewritten(saved, tmp_path / "x.npz", com=plan.com.astype(complex))
        assert "expected real numbers, got complex128" in message(path)
        path = rewritten(saved, tmp_path / "x.npz", phase=plan.phase.astype(float))
        assert "expected integers, got float64" in message(path)
        path = rewritten(saved, tmp_path / "x.npz", joint_names=np.arange(12))
        assert "expected text" in message(path)

    @pytest.mark.parametrize(
        "phase",
        [
            [1, 1, 2, 2],
            [0, 1, 1, 1],
            [0, 0, 2, 2],
            [0, 0, 0, 0],
            [0, 1, 1, 2],  # no interval
            [0, 2, 1, 2],
            [0, 1, 2, 1],
            [0, 1, 2, 3],
            [-1, 0, 1, 2],
        ],
    )
    def test_phases_are_those_of_the_schedule_in_order(self, tmp_path, phase):
        synthetic_plan(intervals=1).save(tmp_path / "plan.npz")
        path = rewritten(tmp_path / "plan.npz", tmp_path / "x.npz", phase=np.array(phase))
        assert (
            'key "phase": expected 0 (take-off), 1 (flight), 2 (landing), each of them with an '
            "interval, in that order"
        ) in message(path)

    def test_the_phases_of_another_schedule_are_named(self, tmp_path):
        plan = synthetic_plan(schedule=TWO_HOPS, durations=TWO_HOPS_DURATIONS)
        plan.save(tmp_path / "plan.npz")
        path = rewritten(tmp_path / "plan.npz", tmp_path / "x.npz", phase=plan.phase % 5)
        assert "1 (rear push), 2 (flight), 3 (rebound), 4 (flight), 5 (front fi" in message(path)

    @pytest.mark.parametrize(
        ("schedule", "said"),
        [
            ({}, "not one that this version wrote"),
            ([], "not one that this version wrote"),
            (together(LEGS[:2]).as_dict(), "it has the legs LF, RF; expected 4"),
            (together(LEGS).as_dict() | {"legs": ["\x1b[2J", *LEGS[1:]]}, "expected names, each"),
            (together(LEGS).as_dict() | {"phases": []}, "it has 0 phases; expected at least three"),
        ],
    )
    def test_what_is_no_schedule(self, saved, tmp_path, schedule, said):
        said_of_it = message(with_meta(saved, tmp_path / "x.npz", schedule=schedule))
        assert 'key "meta": schedule: ' in said_of_it
        assert said in said_of_it

    def test_stones_are_of_legs_that_land(self, saved, tmp_path):
        request = {"robot": "anymal", "stones": {"LF": [0.04, 0.02, 0.0]}}
        path = with_meta(saved, tmp_path / "x.npz", request=request)
        assert load_plan(path).jump == Jump(stones={"LF": (0.04, 0.02)})
        request["stones"] = {"FL": [0.04, 0.02, 0.0]}
        said = message(with_meta(saved, tmp_path / "y.npz", request=request))
        assert 'key "meta": stones: no leg "FL"; expected some of LF, RF, LH, RH' in said


class TestWriting:
    def test_failure_leaves_the_old_file(self, plan, saved, monkeypatch):
        def fail(*_args, **_kwargs):
            raise OSError(28, "No space left on device")

        monkeypatch.setattr(np, "savez_compressed", fail)
        with pytest.raises(InputError, match="No space left"):
            plan.save(saved)
        assert_same(plan, load(saved))
        assert [p.name for p in saved.parent.iterdir()] == [saved.name]
