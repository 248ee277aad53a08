"""Motion-tracking npz files, loaded as mjlab and BeyondMimic load them."""

import json

import numpy as np
import pytest

import llsrbm
from llsrbm.errors import FileFormatError
from llsrbm.formats import export
from llsrbm.motion.whole_body import whole_body_motion
from llsrbm.robots import load_robot
from tests.llsrbm.formats.jumps import (
    by_name,
    depth_first,
    mujoco_model,
    planned,
    replayed,
    same_attitude,
    simulated,
    ticks,
)

ORDERS = ("depth-first", "breadth-first")
FPS = 40


@pytest.fixture(scope="module")
def files(name, tmp_path_factory):
    folder = tmp_path_factory.mktemp("motion")
    for order in ORDERS:
        path = folder / f"{order}.npz"
        export(simulated(name), path, format="motion-npz", fps=FPS, order=order)
    return {order: folder / f"{order}.npz" for order in ORDERS}


def loaded(path):
    with np.load(path) as data:  # without pickle, as the loaders do
        return {key: data[key] for key in data.files}


@pytest.fixture
def arrays(tmp_path):
    """Of a file to damage."""
    export(planned("anymal"), tmp_path / "whole.npz", format="motion-npz")
    return loaded(tmp_path / "whole.npz")


def saved(tmp_path, arrays):
    np.savez(tmp_path / "x.npz", **arrays)
    return tmp_path / "x.npz"


def test_depth_first_bodies_and_joints_stand_where_mujoco_has_them(name, files):
    """mjlab takes them by their places."""
    data, model = loaded(files["depth-first"]), mujoco_model(name)
    assert data["order"] == "depth-first"
    assert data["body_names"].tolist() == [model.body(i + 1).name for i in range(13)]
    assert data["joint_names"].tolist() == depth_first(name)


def test_breadth_first_joints_go_level_by_level(name, files):
    data = loaded(files["breadth-first"])
    assert data["order"] == "breadth-first"
    depth = loaded(files["depth-first"])
    assert set(data["body_names"]) == set(depth["body_names"])
    assert data["body_names"][0] == depth["body_names"][0]
    legs = len(load_robot(name).legs)
    for level in range(0, 12, legs):  # the same joint of every leg
        joints = data["joint_names"][level : level + legs].tolist()
        assert joints == sorted(joints)
        assert len({joint.split("_", 1)[1] for joint in joints}) == 1


@pytest.mark.parametrize("order", ORDERS)
def test_everything_is_as_mujoco_replays_the_rollout(name, files, order):
    """The rollout's own ticks, so that nothing is sampled or differenced on the way."""
    rollout, data = simulated(name), loaded(files[order])
    at = ticks(rollout, FPS)
    joints = rollout.joint_names
    qpos, qvel = rollout.qpos[at], rollout.qvel[at]
    position, quat, velocity, com_velocity, angular = replayed(
        name, joints, qpos, qvel, data["body_names"]
    )
    here = slice(0, len(at))
    wanted = by_name(joints, data["joint_names"], qpos[:, 7:])
    np.testing.assert_allclose(data["joint_pos"][here], wanted, atol=1e-6)
    wanted = by_name(joints, data["joint_names"], qvel[:, 6:])
    np.testing.assert_allclose(data["joint_vel"][here], wanted, atol=1e-6)
    np.testing.assert_allclose(data["body_pos_w"][here], position, atol=1e-6)
    same_attitude(data["body_quat_w"][here], quat, atol=1e-6)
    expected = velocity if order == "depth-first" else com_velocity
    np.testing.assert_allclose(data["body_lin_vel_w"][here], expected, atol=1e-6)
    np.testing.assert_allclose(data["body_ang_vel_w"][here], angular, atol=1e-6)


def test_meta_says_everything_beside(name, files):
    meta = json.loads(str(loaded(files["breadth-first"])["meta"]))
    assert meta["format"] == "motion-npz"
    assert meta["linear_velocity_of"] == "centre of mass of the body"
    assert meta["order"] == "breadth-first"
    assert meta["quaternion_order"] == "wxyz"
    assert meta["request"]["robot"] == name


def test_50_frames_a_second_and_padding(tmp_path):
    plan = planned("go2")
    export(plan, tmp_path / "x.npz", format="motion-npz", pad=0.2)
    data = loaded(tmp_path / "x.npz")
    assert data["fps"][0] == 50
    assert len(data["joint_pos"]) == int(np.ceil(plan.duration * 50 - 1e-6)) + 1 + 20
    for key in ("joint_vel", "body_lin_vel_w", "body_ang_vel_w"):
        np.testing.assert_allclose(data[key][:10], 0, atol=1e-12)
        np.testing.assert_allclose(data[key][-10:], 0, atol=1e-12)
    assert np.ptp(data["body_pos_w"][:11], axis=0).max() == 0


def test_opened_it_is_the_same_motion_in_either_order(name, files):
    truth = whole_body_motion(simulated(name), FPS)
    for order, path in files.items():
        motion = llsrbm.load_motion(path, robot=name)
        assert motion.origin == "motion-npz", order
        assert motion.fps == FPS
        np.testing.assert_allclose(motion.qpos[:, :3], truth.qpos[:, :3], atol=1e-9)
        same_attitude(motion.base_quat, truth.base_quat, atol=1e-12)
        np.testing.assert_allclose(motion.qpos[:, 7:], truth.qpos[:, 7:], atol=1e-9)
        np.testing.assert_allclose(motion.qvel, truth.qvel, atol=1e-8)
        np.testing.assert_allclose(motion.linear_momentum, truth.linear_momentum, atol=1e-4)
        np.testing.assert_allclose(motion.com, truth.com, atol=1e-6)
        assert (motion.contact == truth.contact).mean() > 0.98


def test_the_order_follows_from_the_names(tmp_path, arrays):
    right = llsrbm.load_motion(saved(tmp_path, arrays))
    del arrays["order"]
    told = llsrbm.load_motion(saved(tmp_path, arrays))
    np.testing.assert_array_equal(told.base_velocity, right.base_velocity)
    arrays["joint_names"] = arrays["joint_names"][::-1]
    with pytest.raises(FileFormatError, match=r'"order" is missing.*neither'):
        llsrbm.load_motion(saved(tmp_path, arrays))


def test_a_rate_that_contradicts_the_file_is_remarked_on(tmp_path, arrays):
    rate = llsrbm.load_motion(saved(tmp_path, arrays)).fps
    motion = llsrbm.load_motion(saved(tmp_path, arrays), fps=25)
    assert motion.fps == rate
    assert motion.remarks == (f"it says {rate:g} frames/s: the 25 asked for do not count",)


def test_a_file_without_rate(tmp_path, arrays):
    del arrays["fps"]
    with pytest.raises(FileFormatError, match='"fps" is missing; expected frames per second'):
        llsrbm.load_motion(saved(tmp_path, arrays))
    assert llsrbm.load_motion(saved(tmp_path, arrays), fps=25).fps == 25


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("fps", np.array([0.0]), "0 < fps"),
        ("fps", np.array([np.nan]), "0 < fps"),
        ("fps", np.array([50.0, 60.0]), "expected frames per second"),
        ("fps", np.array("fast"), "expected frames per second"),
        ("order", np.array("bfs"), "expected depth-first or breadth-first, got 'bfs'"),
        ("order", np.array(3), "expected one text"),
        ("joint_names", np.arange(12), "expected text"),
        ("joint_names", np.array(["a\nb"] * 12), "expected names, each of them once"),
        ("joint_pos", np.zeros((3, 12)), "expected shape"),
        ("joint_vel", np.full((1, 12), "x"), "expected shape|expected real"),
        ("body_pos_w", np.zeros((5,)), "expected shape"),
        ("body_quat_w", None, "missing"),
    ],
)
def test_nonsense(tmp_path, arrays, key, value, message):
    if value is None:
        del arrays[key]
    else:
        arrays[key] = value
    with pytest.raises(FileFormatError, match=message) as caught:
        llsrbm.load_motion(saved(tmp_path, arrays))
    assert "\n" not in str(caught.value)


def test_nonsense_numbers(tmp_path, arrays):
    wrong = arrays["body_quat_w"] * 0.5
    with pytest.raises(FileFormatError, match=r"expected unit quaternions"):
        llsrbm.load_motion(saved(tmp_path, arrays | {"body_quat_w": wrong}))
    wrong = arrays["body_lin_vel_w"] + np.inf
    with pytest.raises(FileFormatError, match="expected finite numbers"):
        llsrbm.load_motion(saved(tmp_path, arrays | {"body_lin_vel_w": wrong}))
    wrong = arrays["joint_vel"] + 1e9
    with pytest.raises(FileFormatError, match="expected finite numbers up to"):
        llsrbm.load_motion(saved(tmp_path, arrays | {"joint_vel": wrong}))
    empty = {
        key: arrays[key][:, :0] for key in arrays if key.startswith("body_") and key[-1] == "w"
    }
    with pytest.raises(FileFormatError, match="with at least 1 of each"):
        llsrbm.load_motion(saved(tmp_path, arrays | empty))
