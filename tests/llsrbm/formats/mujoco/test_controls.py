"""A plan replayed by its torques and gains, by a script that knows MuJoCo and NumPy alone."""

import subprocess
import sys

import numpy as np
import pytest

import llsrbm
from llsrbm.formats.mujoco.controls import SCRIPT
from tests.llsrbm.library.shipped_motions import plan


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("mujoco") / "motion"
    llsrbm.export(llsrbm.with_feedback(plan()), path, format="mujoco")
    return path


def replayed(folder, *words):
    # Isolated: neither this package nor its folder are there to be imported.
    return subprocess.run(
        [sys.executable, "-I", "replay.py", *words],
        cwd=folder, capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip


@pytest.mark.parametrize("seed", ["0", "5"])
def test_the_robot_stands_whatever_is_disturbed(folder, seed):
    done = replayed(folder, seed)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("stands: ")


def test_without_gains_it_falls(folder):
    controls = folder / "controls.npz"
    kept = controls.read_bytes()
    arrays = dict(np.load(controls))
    np.savez(controls, **arrays | {"gain": 0 * arrays["gain"]})
    try:
        done = replayed(folder, "0")
    finally:
        controls.write_bytes(kept)
    assert done.returncode == 1
    assert done.stdout.startswith("fell: ")


def test_the_script_is_short_and_knows_no_package_of_ours(folder):
    text = (folder / "replay.py").read_text()
    assert text == SCRIPT
    assert len(text.splitlines()) <= 40
    assert "llsrbm" not in text
    assert "python replay.py" in (folder / "README.txt").read_text()


def test_a_plan_without_gains_has_none_of_it(tmp_path):
    llsrbm.export(plan(), tmp_path / "motion", format="mujoco")
    names = {path.name for path in (tmp_path / "motion").iterdir()}
    assert not names & {"controls.npz", "replay.py"}
    assert "replay.py" not in (tmp_path / "motion" / "README.txt").read_text()
