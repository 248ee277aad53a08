"""Plans and simulations opened in a real browser, by the button and by dropping them."""

import zipfile

import numpy as np
import pytest

from llsrbm.request.jump import Jump
from tests.app.chromium import (
    COMPARE,
    PACE,
    dark,
    drop,
    fill,
    number,
    paused_at,
    picture,
    player,
    press,
    status,
    tab,
    unfold,
)
from tests.app.planners import turning_states
from tests.app.synthetic_plan import synthetic_plan
from tests.app.waits import wait_until
from tests.llsrbm.synthetic_rollout import synthetic_rollout

JUMP = Jump(robot="anymal", twist=1.0, forward=0.3)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("files")
    plan = synthetic_plan(JUMP)
    plan.save(folder / "plan.npz")
    synthetic_rollout(plan).save(folder / "run.npz")
    return folder


def test_a_plan_is_opened_by_the_button_changed_and_simulated(page, files):
    page.locator("input[type=file]").set_input_files(files / "plan.npz")
    wait_until(lambda: page.session.state.plan.jump == JUMP, "the plan")
    status(page, "Draft from file plan.npz")
    assert float(number(page, "Twist [deg]").input_value()) == 57
    assert float(number(page, "Forward [m]").input_value()) == 0.3
    wait_until(lambda: player(page, "clip.end") == pytest.approx(1.3), "its motion")
    paused_at(page, 1.3)
    wait_until(lambda: dark(picture(page)).sum() > 3000, "the robot")
    fill(page, "Forward [m]", 0.4)
    wait_until(lambda: page.session.state.plan.jump.forward == 0.4, "the next plan")
    status(page, "Feasible")
    press(page, "Simulate")
    status(page, "Landed")


def test_a_simulation_is_dropped_and_saved(page, files, tmp_path):
    drop(page, "run.npz", (files / "run.npz").read_bytes())
    page.get_by_role("status").filter(has_text="Landed from file run.npz").wait_for()
    wait_until(lambda: player(page, "clip.end") == pytest.approx(2.3), "its motion")
    unfold(page, "Several in one zip")
    for name in ("csv", "design"):
        page.get_by_label(name, exact=True).check()
        page.wait_for_timeout(PACE)
    with page.expect_download() as download:
        press(page, "Export")
    assert download.value.suggested_filename == "anymal_twist57_forward30cm_simulated.zip"
    download.value.save_as(tmp_path / "out.zip")
    with zipfile.ZipFile(tmp_path / "out.zip") as archive:
        assert len(archive.namelist()) == 4  # npz, csv, what describes it, design
    for name in ("csv", "design"):
        page.get_by_label(name, exact=True).uncheck()
        page.wait_for_timeout(PACE)


def test_another_tools_motion_stands_beside_the_plan(page, tmp_path):
    motion = turning_states("anymal").motion()
    rows = np.hstack(
        [motion.base_position, np.roll(motion.base_quat, -1, 1), motion.joint_position]
    )
    np.savetxt(tmp_path / "turn.csv", rows, fmt="%.9f", delimiter=",")
    drop(page, "turn.csv", (tmp_path / "turn.csv").read_bytes())
    page.get_by_text("turn.csv is pinned for looking and comparing, at 30 frames/s.").wait_for()
    tab(page, "Files")
    number(page, "Rate of the file [1/s]").wait_for()
    tab(page, COMPARE)
    page.locator("table").filter(has_text="motion").wait_for()
    # It goes on when the plan has ended.
    wait_until(lambda: player(page, "clip.end") == pytest.approx(100 / 30), "a clip with both")


def test_a_bad_file_is_one_line(page):
    drop(page, "bad.npz", b"PK\x03\x04nothing")
    note = page.get_by_text("bad.npz: ")
    note.wait_for()
    assert note.count() == 1
    assert "\n" not in note.inner_text()
    wait_until(lambda: page.get_by_text("uploaded").count() == 0, "viser's own note to go")
    status(page, "Feasible")
