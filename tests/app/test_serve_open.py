"""`llsrbm serve --open FILE`: every tab begins with it, or nothing is served."""

from unittest.mock import MagicMock

import pytest

from app.designer import Designer
from app.workers.file_reading import open_file
from app.workers.opened_file import OpenedFile
from llsrbm.request.design import Design, dump_design
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from llsrbm.robots import names
from llsrbm.robots.schema import read_robot_file, robot_files
from tests.app.planners import SyntheticPlanner, turning_states
from tests.app.raw_tab import RawTab, planned
from tests.app.synthetic_plan import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout

ROBOTS = ", ".join(names())
JUMP = Jump(robot="go2", model="srbm", twist=0.3)


@pytest.fixture
def served():
    running = []

    def serve(file):
        running.append(Designer(port=0, token="none", planner=SyntheticPlanner, file=file))
        return running[-1]

    yield serve
    for designer in running:
        designer.close()


def test_every_tab_begins_with_the_simulation(served, tmp_path):
    rollout = synthetic_rollout(synthetic_plan(JUMP))
    rollout.save(tmp_path / "run.npz")
    designer = served(open_file("run.npz", (tmp_path / "run.npz").read_bytes(), "anymal"))
    for _ in range(2):
        # What the browser kept is not asked for.
        with RawTab(designer.port, {"kept": dump_design(Design(Jump(twist=1.0)))}) as tab:
            tab.wait_for_status("Landed from file run.npz")
            assert tab.value("Robot") == read_robot_file(robot_files()["go2"]).title
            session = designer.sessions[-1]
            assert session.state.plan.jump == JUMP
            tab.set("Twist [deg]", 10)
            tab.wait_for_status("Feasible")
            assert session.state.rollout is None


def test_a_design_is_planned(served):
    design = Design(Jump(robot="slider", twist=0.2), scenario=Scenario(seed=3))
    designer = served(open_file("mine.jump.json", dump_design(design).encode(), "anymal"))
    with RawTab(designer.port) as tab:
        tab.wait_for_status("Feasible")
        planned(tab, designer.sessions[-1], lambda jump: jump.robot == "slider", "its plan")
        assert tab.value("Seed") == 3


def test_another_tools_motion_is_pinned_beside_its_robots_example(served):
    designer = served(OpenedFile("turn.csv", turning_states("go2")))
    with RawTab(designer.port) as tab:
        tab.wait_for_status("Feasible")
        tab.wait(lambda: any(name.startswith("/pinned/1/") for name in tab.nodes), "a ghost")
        assert designer.sessions[-1].state.plan.jump.robot == "go2"


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["nosuch.npz"], "--open: nosuch.npz: cannot be read (No such file or directory)"),
        (["/dev/null"], "--open: /dev/null: expected a file"),
        (["bad.npz"], "bad.npz: not an npz file"),
        (["bad.json"], "bad.json: not a JSON file"),
        (
            ["bad.npz", "--robot", "/dev/zero"],
            f"--robot: expected one of {ROBOTS}, got",
        ),
    ],
)
def test_a_bad_file_is_one_line_and_nothing_is_served(
    tmp_path, monkeypatch, refused, arguments, told
):
    monkeypatch.chdir(tmp_path)
    for name in ("bad.npz", "bad.json"):
        (tmp_path / name).write_bytes(b"bad")
    monkeypatch.setattr("app.workers.pool.WorkerPool", None)  # is not reached
    assert told in refused("serve", "--open", *arguments)


def test_a_folder_without_a_sweep_is_one_line_and_nothing_is_served(tmp_path, monkeypatch, refused):
    monkeypatch.setattr("app.workers.pool.WorkerPool", MagicMock())
    monkeypatch.setattr("app.designer.serve", None)  # is not reached
    assert "no jumps.parquet there" in refused("serve", "--atlas", str(tmp_path))


@pytest.mark.parametrize("arguments", [["--robot", "go2"], ["--fps", "50"]])
def test_what_is_of_a_file_alone_is_refused_without_one(monkeypatch, refused, arguments):
    """The page began with its own robot, whatever was asked for."""
    monkeypatch.setattr("app.workers.pool.WorkerPool", None)  # is not reached
    told = refused("serve", *arguments)
    assert told.startswith(f"{arguments[0]}: ")
    assert "expected --open FILE beside it" in told
