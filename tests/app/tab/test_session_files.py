"""Files in and out of one tab: opened without solving again, and gone on from; saved in formats."""

import io
import json
import math
import zipfile
from dataclasses import replace

import numpy as np
import pytest

import llsrbm
from app.workers.tasks import PlanJump
from llsrbm.ocp.horizon import Iterate
from llsrbm.request.design import Design, dump_design, load_design
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from llsrbm.request.tuning import Tuning
from tests.app.planners import SLOW_PAD
from tests.app.raw_tab import planned
from tests.app.synthetic_plan import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout

# Of no control's step, so that nobody could have planned it from the controls.
JUMP = Jump(robot="anymal", model="srbm", twist=1.234, forward=0.123, lateral=-0.1, height=0.1)
TUNING = Tuning(limits={"friction": 0.45})
SCENARIO = Scenario(board=0.02, half_board=True, seed=7, noise=2.0)
SOLUTION = Iterate(np.arange(5.0), np.arange(3.0))


def plan_of(jump=JUMP, **changes):
    return replace(synthetic_plan(jump), tuning=TUNING, solution=SOLUTION, **changes)


def rollout_of(plan, **changes):
    return replace(synthetic_rollout(plan), scenario=SCENARIO, **changes)


def content(trajectory, tmp_path):
    path = tmp_path / "file.npz"
    trajectory.save(path)
    return path.read_bytes()


@pytest.fixture
def submitted(session, monkeypatch):
    """Tasks that the session asks the pool for."""
    asked, submit = [], session._pool.submit

    def note(tab, task, listener):
        asked.append(task)
        return submit(tab, task, listener)

    monkeypatch.setattr(session._pool, "submit", note)
    return asked


# ---- plans


def test_another_robots_numbers_are_told(tab, session, submitted, tmp_path):
    parameters = synthetic_plan(JUMP).robot_parameters
    other = plan_of(robot_parameters=parameters | {"mass": 44.0})
    tab.upload("Open", "heavy.npz", content(other, tmp_path))
    planned(tab, session, lambda jump: jump == JUMP, "the plan")
    tab.wait(lambda: "It was made with another anymal (mass)" in tab.text(), "the remark")
    tab.set("Forward [m]", 0.15)
    planned(tab, session, lambda jump: jump.forward == 0.15, "the next plan")
    assert next(t for t in submitted if isinstance(t, PlanJump)).near is None


# ---- simulations


def test_what_was_saved_opens_as_it_was(tab, session):
    tab.press("Simulate")
    tab.wait_for_status("Landed")
    rollout = session.state.rollout
    tab.press("Export")
    tab.wait(lambda: tab.downloads, "a download")
    tab.set("Forward [m]", 0.2)
    planned(tab, session, lambda jump: jump.forward == 0.2, "another plan")
    tab.upload("Open", *tab.downloads[0])
    tab.wait_for_status("Landed from file")
    assert session.state.rollout.com.tolist() == rollout.com.tolist()
    assert session.state.plan.jump == rollout.jump


# ---- for looking


def test_what_was_saved_for_other_tools_comes_back_for_looking(tab, session, script):
    tab.set("Format", "unitree-csv")
    tab.wait(lambda: tab.control("Frames per second")["props"]["visible"], "its options")
    name, data = save(tab)
    fps = tab.value("Frames per second")
    assert fps == tab.value("Rate of the file [1/s]")  # as both are usual
    tab.upload("Open", name, data)
    tab.wait(lambda: "/row/0-1/base" in script.nodes(), "its motion, beside")
    for instant in (0.0, 0.6, 1.2):
        apart = script.at("/row/0-1/base", instant)[0] - script.at("/links/base", instant)[0]
        assert apart[[0, 2]] == pytest.approx([0, 0], abs=0.05)
    assert tab.control("Rate of the file [1/s]")["props"]["visible"]


# ---- refusals


def test_a_bad_file_is_one_line_and_nothing_changes(tab, session, tmp_path):
    before, status = session.state.plan, tab.status()
    good = content(plan_of(), tmp_path)
    for number, (name, bad) in enumerate(
        [("a.npz", b"PK"), ("b.npz", good[:1000]), ("c.json", b"{"), ("d", b""), ("e.csv", b"a,b")]
    ):
        tab.upload("Open", name, bad, transfer=str(number))
        tab.wait(lambda n=number: len(tab.notifications) > n, "a refusal")
        title, body = tab.notifications[-1]
        assert title == "Not opened"
        assert body.startswith(f"{name}: ")
        assert "\n" not in body
        assert "/tmp" not in body
        assert body not in tab.text()  # it is said once
    assert session.state.plan is before
    assert tab.status() == status
    tab.upload("Open", "good.npz", good, transfer="good")
    planned(tab, session, lambda jump: jump == JUMP, "a good one")


# ---- saving


def save(tab, count=1):
    tab.press("Export")
    tab.wait(lambda: len(tab.downloads) >= count, "a download")
    return tab.downloads[-1]


def test_several_formats_are_one_zip(tab, session):
    tab.set("Format", "csv")
    tab.set("design", True)
    name, data = save(tab)
    assert name == "anymal_twist90.zip"
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        assert sorted(archive.namelist()) == [
            "anymal_twist90.csv",
            "anymal_twist90.csv.meta.json",
            "anymal_twist90.jump.json",
        ]
        design = load_design(archive.read("anymal_twist90.jump.json"))
    assert design.jump == session.state.plan.jump


def test_a_format_takes_its_options(tab, session):
    rate = tab.control("Frames per second")
    assert not rate["props"]["visible"]
    tab.set("Format", "csv")
    tab.wait(lambda: tab.control("Frames per second")["props"]["visible"], "the rate")
    assert not tab.control("Padding before and after [s]")["props"]["visible"]
    assert "a table for people" in tab.text()
    tab.set("Frames per second", 10)
    _, data = save(tab)
    rows = np.genfromtxt(io.BytesIO(data), delimiter=",", skip_header=1)
    assert np.diff(rows[:, 0]).max() == pytest.approx(0.1)
    tab.set("Frames per second", 1e9)
    save(tab, 2)
    assert tab.notifications == [
        ("Corrected", "Frames per second: expected 1 to 1000, got 1e+09; the nearest is taken")
    ]


def test_a_format_that_is_none_is_corrected(tab, session):
    tab.set("Format", "../nosuch")
    assert save(tab)[0] == "anymal_twist90.npz"
    assert tab.notifications[0][0] == "Corrected"


def test_saving_can_be_given_up_and_blocks_nobody(designer, tab, session):
    pad = "Padding before and after [s]"
    tab.set("Format", "unitree-csv")
    tab.wait(lambda: tab.control(pad)["props"]["visible"], "the format's options")
    tab.set(pad, SLOW_PAD)  # the planner under test takes a minute for that
    tab.press("Export")
    tab.wait(lambda: "Exporting unitree-csv" in tab.text(), "that it is being saved")
    assert tab.control("Export")["props"]["disabled"]
    assert not tab.control("Cancel")["props"]["visible"]
    assert tab.status().startswith("Feasible")
    tab.set("Forward [m]", 0.2)
    planned(tab, session, lambda jump: jump.forward == 0.2, "a plan meanwhile")
    assert "Exporting unitree-csv" in tab.text()
    tab.press("Stop")
    tab.wait(lambda: ("Not exported", "Stopped: unitree-csv") in tab.notifications, "the end of it")
    tab.wait(lambda: not tab.control("Export")["props"]["disabled"], "the button")
    assert "Exporting" not in tab.text()
    tab.set(pad, 0)
    assert save(tab)[0].endswith(".csv")


def test_what_a_design_asks_is_saved_and_opened(tab, session):
    design = Design(replace(JUMP, twist=math.radians(30), forward=0.1), TUNING, SCENARIO)
    tab.upload("Open", "mine.jump.json", dump_design(design).encode())
    planned(tab, session, lambda jump: jump == design.jump, "its plan")
    tab.wait_for_status("Feasible")
    tab.press("Simulate")
    tab.wait_for_status("Landed")
    tab.set("Format", "design")
    name, data = save(tab)
    assert name == "anymal_twist30_forward10cm_right10cm_up10cm_srbm_simulated.jump.json"
    assert load_design(data) == design
    assert json.loads(data)["scenario"]["seed"] == 7
    assert llsrbm.load_design(data).tuning == TUNING
