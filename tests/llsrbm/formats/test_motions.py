"""Motions that are neither plans nor rollouts, written as a plan at the same rate is."""

import json
import pickle
import zipfile
from dataclasses import replace

import numpy as np
import pytest

import llsrbm
from llsrbm.formats import check_motion_format
from llsrbm.motion.whole_body import whole_body_motion
from tests.llsrbm.player.stages import stored_plan

FPS = 40.0
WRITTEN = ("unitree-csv", "motion-npz", "mimickit-pkl", "gmr-pkl", "motion-imitation-json")


@pytest.fixture(scope="module")
def motion():
    return whole_body_motion(stored_plan(), FPS)


def numbers(path, name):
    """All numbers of a file, and none of what is said about them."""
    if name == "motion-npz":
        with np.load(path) as file:
            found = {key: file[key] for key in file.files if key != "meta"}
        return {key: value for key, value in found.items() if value.dtype.kind == "f"}
    if name == "unitree-csv":
        return {"rows": np.loadtxt(path, delimiter=",")}
    if name == "motion-imitation-json":
        table = json.loads(path.read_text("utf-8"))
        return {key: np.array(table[key]) for key in ("Frames", "FrameDuration")}
    content = pickle.loads(path.read_bytes())
    return {k: np.array(v) for k, v in content.items() if k not in ("link_body_list",)}


@pytest.mark.parametrize("name", WRITTEN)
def test_its_frames_are_those_of_the_plan(name, motion, tmp_path):
    llsrbm.export(stored_plan(), tmp_path / "plan", format=name, fps=FPS)
    llsrbm.export(motion, tmp_path / "motion", format=name)
    expected = numbers(tmp_path / "plan", name)
    found = numbers(tmp_path / "motion", name)
    assert found.keys() == expected.keys()
    for key, values in expected.items():
        np.testing.assert_array_equal(found[key], values, err_msg=key)


def test_it_is_described_as_a_motion(motion, tmp_path):
    llsrbm.export(motion, tmp_path / "motion.csv", format="unitree-csv")
    beside = json.loads((tmp_path / "motion.csv.meta.json").read_text("utf-8"))
    assert (beside["kind"], beside["robot"]["name"], beside["fps"]) == ("motion", "go2", FPS)
    again = llsrbm.load_motion(tmp_path / "motion.csv", robot="go2")
    assert again.fps == FPS
    np.testing.assert_allclose(again.joint_position, motion.joint_position, atol=1e-8)


def test_several_formats_go_into_a_zip(motion, tmp_path):
    names = ["motion-npz", "gmr-pkl"]
    llsrbm.export(motion, tmp_path / "all.zip", format=names, order="breadth-first")
    with zipfile.ZipFile(tmp_path / "all.zip") as archive:
        found = set(archive.namelist())
    assert {"go2_motion_motion.npz", "go2_motion_gmr.pkl"} <= found


def test_the_bodies_order_can_be_asked_for(motion, tmp_path):
    llsrbm.export(motion, tmp_path / "m.npz", format="motion-npz", order="breadth-first")
    with np.load(tmp_path / "m.npz") as file:
        assert str(file["order"]) == "breadth-first"
        assert json.loads(str(file["meta"]))["fps"] == FPS


def test_a_format_of_plans_alone_is_refused(motion, tmp_path):
    with pytest.raises(llsrbm.InputError, match=r'format "csv" is of plans.*expected unitree-csv'):
        llsrbm.export(motion, tmp_path / "m.csv", format="csv")
    with pytest.raises(llsrbm.InputError, match='format "npz" is of plans'):
        check_motion_format("npz")


@pytest.mark.parametrize("option", ["fps", "pad"])
def test_its_frames_are_not_resampled(motion, tmp_path, option):
    with pytest.raises(llsrbm.InputError, match=f"{option}: is not for a motion"):
        llsrbm.export(motion, tmp_path / "m.npz", format="motion-npz", **{option: 1.0})


def test_frames_that_are_not_even_are_refused(motion, tmp_path):
    with pytest.raises(llsrbm.InputError, match="not evenly spaced"):
        llsrbm.export(replace(motion, fps=None), tmp_path / "m.npz", format="motion-npz")
