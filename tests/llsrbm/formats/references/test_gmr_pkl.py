"""GMR's pickles, unpickled as its loader does."""

import json
import pickle
import pickletools

import numpy as np
import pytest

from llsrbm.formats import export
from tests.llsrbm.formats.jumps import (
    check_frames,
    depth_first,
    mujoco_model,
    planned,
    replayed,
    simulated,
)

FPS = 50


@pytest.fixture(scope="module")
def path(name, tmp_path_factory):
    path = tmp_path_factory.mktemp("gmr") / "jump.pkl"
    export(simulated(name), path, format="gmr-pkl", fps=FPS)
    return path


@pytest.fixture(scope="module")
def content(path):
    return pickle.loads(path.read_bytes())


def test_keys_and_shapes(content):
    frames = len(content["root_pos"])
    shapes = {key: np.shape(value) for key, value in content.items()}
    assert shapes == {
        "fps": (),
        "root_pos": (frames, 3),
        "root_rot": (frames, 4),
        "dof_pos": (frames, 12),
        "local_body_pos": (frames, 13, 3),
        "link_body_list": (13,),
    }
    assert content["fps"] == FPS
    content["root_pos"][:, 2] += 0.0  # its users change them in place


def test_it_names_nothing_that_only_numpy_2_has(path):
    """Simulators are tied to old ones."""
    strings, named = [], set()
    for op, argument, _ in pickletools.genops(path.read_bytes()):
        if op.name in ("SHORT_BINUNICODE", "BINUNICODE"):
            strings.append(argument)
        if op.name == "STACK_GLOBAL":
            named.add(tuple(strings[-2:]))
    assert named == {("numpy", "array")}


def test_frames_are_the_simulators(name, content):
    quat = content["root_rot"][:, [3, 0, 1, 2]]  # as the loader turns them for MuJoCo
    check_frames(name, FPS, content["root_pos"], quat, content["dof_pos"], depth_first(name))


def test_bodies_are_seen_from_the_root(name, content):
    """MuJoCo with the root at rest at the origin."""
    model = mujoco_model(name)
    bodies = [model.body(i + 1).name for i in range(13)]
    assert content["link_body_list"] == bodies
    at_rest = np.tile([0.0, 0, 0, 1, 0, 0, 0], (len(content["dof_pos"]), 1))
    qpos = np.hstack([at_rest, content["dof_pos"]])
    position, *_ = replayed(name, depth_first(name), qpos, np.zeros((len(qpos), 18)), bodies)
    np.testing.assert_allclose(content["local_body_pos"], position, atol=1e-6)


def test_what_stands_beside_and_the_rate(tmp_path):
    export(planned("anymal"), tmp_path / "x.pkl", format="gmr-pkl", pad=0.1)
    content = pickle.loads((tmp_path / "x.pkl").read_bytes())
    assert content["fps"] == 30
    assert np.ptp(content["dof_pos"][:4], axis=0).max() == 0
    told = json.loads((tmp_path / "x.pkl.meta.json").read_text())
    assert told["joint_order"][3] == "RF_HAA"  # the URDF's, not the alphabet's
    assert told["quaternion_order"] == "xyzw"
