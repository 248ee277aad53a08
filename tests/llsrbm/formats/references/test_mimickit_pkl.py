"""MimicKit's pickles, unpickled and turned as its loader does."""

import json
import pickle
import pickletools

import numpy as np
import pytest

from llsrbm.formats import export
from llsrbm.formats.trainers import exponential_map
from tests.llsrbm.formats.jumps import check_frames, depth_first, simulated

FPS = 50


@pytest.fixture(scope="module")
def path(name, tmp_path_factory):
    path = tmp_path_factory.mktemp("mimickit") / "jump.pkl"
    export(simulated(name), path, format="mimickit-pkl", fps=FPS)
    return path


@pytest.fixture(scope="module")
def content(path):
    return pickle.loads(path.read_bytes())


@pytest.fixture(scope="module")
def frames(content):
    return np.array(content["frames"])


def quaternions(maps):
    """w, x, y, z of exponential maps: cosine and sine of half the angle about the axis, the angle
    first brought to -180 to 180 deg."""
    angle = np.linalg.norm(maps, axis=1, keepdims=True)
    axis = maps / np.where(angle == 0, 1, angle)
    angle = np.arctan2(np.sin(angle), np.cos(angle))
    return np.hstack([np.cos(angle / 2), axis * np.sin(angle / 2)])


def test_keys_and_types(content, frames):
    assert list(content) == ["loop_mode", "fps", "frames"]
    assert content["loop_mode"] == 0  # clamp
    assert content["fps"] == FPS
    assert isinstance(content["frames"], list)
    assert frames.shape[1] == 3 + 3 + 12


def test_it_opens_without_numpy(path):
    assert not [op for op, *_ in pickletools.genops(path.read_bytes()) if "GLOBAL" in op.name]


def test_frames_are_the_simulators(name, frames):
    quat = quaternions(frames[:, 3:6])
    check_frames(name, FPS, frames[:, :3], quat, frames[:, 6:], depth_first(name))


def test_beyond_180_degrees_the_map_does_not_jump():
    angle = np.linspace(0, 1.6 * np.pi, 50)
    tilt = np.array([0.1, -0.2, 1.0]) / np.linalg.norm([0.1, -0.2, 1.0])
    quat = np.hstack([np.cos(angle / 2)[:, None], np.sin(angle / 2)[:, None] * tilt])
    for signed in (quat, -quat):
        np.testing.assert_allclose(exponential_map(signed), angle[:, None] * tilt, atol=1e-12)


def test_what_stands_beside(name, path):
    told = json.loads(path.with_name(path.name + ".meta.json").read_text())
    assert told["joint_order"] == depth_first(name)
    assert told["columns"][:6] == ["x", "y", "z", "rx", "ry", "rz"]
    assert told["request"]["robot"] == name
