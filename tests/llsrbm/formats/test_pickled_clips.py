"""Pickles of trainers and retargeters are read as the motions that they are."""

import json
import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import llsrbm
from llsrbm.errors import FileFormatError
from llsrbm.formats.base import ORDERS
from llsrbm.library import shipped
from llsrbm.motion.bodies import body_order
from llsrbm.robots import load_robot

NAMES = {"go2": "go2-together-0001", "g1": "g1-together-0005", "anymal": "anymal-together-0001"}
FPS = 50.0


@pytest.fixture(scope="module", params=NAMES)
def robot(request):
    return request.param


@pytest.fixture(scope="module")
def truth(robot, tmp_path_factory):
    """The motion by way of a file that names its joints."""
    path = tmp_path_factory.mktemp("truth") / "clip.npz"
    plan = shipped().open(NAMES[robot], check=False)
    llsrbm.export(plan, path, format="motion-npz", fps=FPS)
    return plan, llsrbm.load_motion(path, robot)


def same(found, motion):
    np.testing.assert_allclose(found.base_position, motion.base_position, atol=1e-6)
    turned = Rotation.from_quat(found.base_quat, scalar_first=True).inv() * Rotation.from_quat(
        motion.base_quat, scalar_first=True
    )
    assert turned.magnitude().max() < 1e-6
    np.testing.assert_allclose(found.joint_position, motion.joint_position, atol=1e-6)
    assert found.fps == motion.fps


@pytest.mark.parametrize("format_", ["gmr-pkl", "mimickit-pkl"])
@pytest.mark.parametrize("beside", [True, False])
def test_what_was_exported_is_read_again(robot, truth, format_, beside, tmp_path):
    plan, motion = truth
    path = tmp_path / "clip.pkl"
    llsrbm.export(plan, path, format=format_, fps=FPS)
    if not beside:
        path.with_name("clip.pkl.meta.json").unlink()
    same(llsrbm.load_motion(path, robot), motion)


def of_its_kin(motion, joints, **changed):
    """The layout of human2humanoid, PHC and ASAP."""
    place = [motion.robot.joint_names.index(name) for name in joints]
    clip = {
        "root_trans_offset": motion.base_position.astype(np.float32),
        "root_rot": motion.base_quat[:, [1, 2, 3, 0]],
        "dof": motion.joint_position[:, place],
        "fps": FPS,
    }
    return {"a clip": clip | changed}


def test_a_clip_of_human2humanoids_kin(truth, robot, tmp_path):
    _, motion = truth
    path = tmp_path / "clip.pkl"
    moving = set(motion.robot.joint_names)
    joints = [each for each in body_order(motion.robot, ORDERS[0]).joints if each in moving]
    path.write_bytes(pickle.dumps(of_its_kin(motion, joints)))
    same(llsrbm.load_motion(path, robot), motion)


def test_g1_without_wrists(tmp_path):
    """23 joints: legs, the whole waist, arms to the elbows."""
    robot = load_robot("g1")
    plan = shipped().open(NAMES["g1"], check=False)
    llsrbm.export(plan, tmp_path / "gmr.pkl", format="gmr-pkl", fps=FPS)
    order = json.loads((tmp_path / "gmr.pkl.meta.json").read_text())["joint_order"]
    content = pickle.loads((tmp_path / "gmr.pkl").read_bytes())
    without = [place for place, name in enumerate(order) if "wrist" not in name]
    assert len(without) == 23
    clip = of_its_kin(llsrbm.load_motion(tmp_path / "gmr.pkl", "g1"), robot.joint_names)
    clip["a clip"]["dof"] = content["dof_pos"][:, without]
    path = tmp_path / "clip.pkl"
    path.write_bytes(pickle.dumps(clip))
    same(llsrbm.load_motion(path, "g1"), llsrbm.load_motion(tmp_path / "gmr.pkl", "g1"))


def test_what_is_none_is_said_in_one_sentence(tmp_path):
    rows, path = np.zeros((9, 4)), tmp_path / "clip.pkl"
    clip = {"root_pos": rows[:, :3], "root_rot": np.eye(4)[[3] * 9], "fps": 30}
    for content, words in [
        ([1, 2], "expected a dictionary with"),
        ({}, "has no keys; expected"),
        ({"a": {"x": 1}, "b": {"x": 1}}, r"has 2 clips \(a, b\); expected a file of each"),
        (clip, "has root_pos, root_rot, fps; expected"),
        (clip | {"dof_pos": rows[:5]}, "with as many frames each"),
        (clip | {"dof_pos": "text"}, 'key "dof_pos": expected a row of numbers a frame'),
        (clip | {"dof_pos": rows}, "has 4 joints; expected 12 of robot go2"),
        (clip | {"dof_pos": np.zeros((9, 12)), "fps": None}, 'key "fps" is missing'),
        ({"frames": [[0.0] * 18, [0.0] * 17]}, 'key "frames": expected a row of numbers'),
    ]:
        path.write_bytes(pickle.dumps(content))
        with pytest.raises(FileFormatError, match=words):
            llsrbm.load_motion(path, "go2")


def test_joints_that_are_no_names_are_refused(tmp_path):
    path = tmp_path / "clip.pkl"
    path.write_bytes(pickle.dumps({"frames": [[0.0] * 18] * 9, "fps": 30}))
    path.with_name("clip.pkl.meta.json").write_text('{"joint_order": 3}')
    with pytest.raises(FileFormatError, match="joint_order: expected a list of names"):
        llsrbm.load_motion(path, "go2")
