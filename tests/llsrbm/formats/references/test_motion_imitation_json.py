"""Clips of motion_imitation, read as its loader reads them."""

import json

import numpy as np
import pytest

from llsrbm.formats import export
from tests.llsrbm.formats.jumps import (
    by_name,
    mujoco_model,
    planned,
    same_attitude,
    simulated,
    ticks,
)

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
    rollout = simulated(name)
    at = ticks(rollout, FPS)
    qpos, here = rollout.qpos[at], frames[: len(at)]
    np.testing.assert_allclose(here[:, :3], qpos[:, :3], atol=1e-6)
    same_attitude(here[:, 3:7], qpos[:, [4, 5, 6, 3]], atol=1e-6)
    model = mujoco_model(name)
    assert content["JointOrder"] == [model.joint(i + 1).name for i in range(12)]
    wanted = by_name(rollout.joint_names, content["JointOrder"], qpos[:, 7:])
    np.testing.assert_allclose(here[:, 7:], wanted, atol=1e-6)


def test_the_quaternion_ends_with_w_is_one_and_does_not_jump(name, frames):
    quat = frames[:, 3:7]
    np.testing.assert_allclose(quat[0], [0, 0, 0, 1], atol=0.02)
    np.testing.assert_allclose(np.linalg.norm(quat, axis=1), 1, atol=1e-8)
    assert (np.sum(quat[1:] * quat[:-1], axis=1) > 0.9).all()
    assert 2 * np.arctan2(quat[-1, 2], quat[-1, 3]) == pytest.approx(
        planned(name).jump.twist, abs=0.1
    )


def test_60_frames_a_second_and_padding(tmp_path):
    export(planned("slider"), tmp_path / "x.json", format="motion-imitation-json", pad=0.5)
    content = json.loads((tmp_path / "x.json").read_text())
    assert content["FrameDuration"] == 1 / 60
    frames = np.array(content["Frames"])
    assert np.ptp(frames[:31], axis=0).max() == 0
    assert np.ptp(frames[-31:], axis=0).max() == 0
