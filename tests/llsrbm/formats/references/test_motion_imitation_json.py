"""Clips of motion_imitation, read as its loader reads them."""

import json

import numpy as np
import pytest

from llsrbm.formats import export
from tests.llsrbm.formats.jumps import check_frames, depth_first, planned, simulated

FPS = 50


@pytest.fixture(scope="module")
def content(name, tmp_path_factory):
    path = tmp_path_factory.mktemp("clip") / "jump.json"
    export(simulated(name), path, format="motion-imitation-json", fps=FPS)
    assert [file.name for file in path.parent.iterdir()] == ["jump.json"]
    return json.loads(path.read_text())


@pytest.fixture(scope="module")
def frames(content):
    return np.array(content["Frames"])


def test_keys(content, frames):
    assert content["LoopMode"] == "Clamp"
    assert content["FrameDuration"] == 1 / FPS
    assert content["EnableCycleOffsetPosition"] is False
    assert content["EnableCycleOffsetRotation"] is False
    assert frames.shape[1] == 3 + 4 + 12


def test_frames_are_the_simulators(name, content, frames):
    assert content["JointOrder"] == depth_first(name)
    quat = frames[:, [6, 3, 4, 5]]
    check_frames(name, FPS, frames[:, :3], quat, frames[:, 7:], content["JointOrder"])


def test_60_frames_a_second_and_padding(tmp_path):
    export(planned("slider"), tmp_path / "x.json", format="motion-imitation-json", pad=0.5)
    content = json.loads((tmp_path / "x.json").read_text())
    assert content["FrameDuration"] == 1 / 60
    frames = np.array(content["Frames"])
    assert np.ptp(frames[:31], axis=0).max() == 0
    assert np.ptp(frames[-31:], axis=0).max() == 0
