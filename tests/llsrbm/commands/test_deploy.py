"""`llsrbm deploy`: what it prints and refuses, and a robot behind DDS that it plays on."""

import json
import os
import random
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import llsrbm
from llsrbm.cli import main
from llsrbm.installed import assets_directory
from llsrbm.player.posture import FirstPosture, gains
from llsrbm.robots import load_robot
from tests.llsrbm.wire.simulator_process import STARTS, simulator

PLANS = assets_directory() / "plans"
BUSY = "deadlines:|lost link:|late:"  # what a busy machine may do to a player


def test_a_dry_run_prints_states_and_first_commands(capsys):
    assert main(["deploy", str(PLANS / "go1.npz"), "--tier", "table", "--dry-run"]) == 0
    out = capsys.readouterr().out
    states = re.findall(r"^(\w+) +(\d+\.\d\d) s ", out, re.MULTILINE)
    assert [name for name, _ in states] == ["check", "ramp", "stand", "jump", "damp"]
    jump = llsrbm.load(PLANS / "go1.npz").duration + 1.0  # and a second of standing
    assert float(dict(states)["jump"]) == pytest.approx(jump, abs=0.005)
    assert "FR_calf_joint" in out
    assert out.endswith("Nothing was sent.\n")


@pytest.mark.parametrize("tier", ["table", "closed-loop"])
def test_a_dry_run_as_json(tier, capfd):
    plan = PLANS / "go1.npz"
    assert main(["deploy", str(plan), "--robot", "go1", "--tier", tier, "--dry-run", "--json"]) == 0
    result = json.loads(capfd.readouterr().out)
    assert result["tier"] == tier
    assert [command["time_s"] for command in result["commands"]] == [0.0, 0.002, 0.004]
    first, robot = result["commands"][0], load_robot("go1")
    if tier == "table":
        posture = FirstPosture.of(llsrbm.load(plan), robot)
        assert first["q"] == pytest.approx(posture.joints, abs=0.01)
        assert first["kp"] == gains(robot)[0].tolist()
    else:
        assert not np.any(first["kp"])
        assert (np.array(first["kd"]) > 0).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((PLANS / "go1.npz", "--robot", "anymal"), r"of robot go1, the robot .* is anymal"),
        ((PLANS / "go1.npz", "--tier", "loop"), r'no tier "loop"'),
        ((PLANS / "go1.npz", "--log", "play.csv"), r"--log play.csv: expected a name .*\.mcap"),
        ((PLANS / "go1.npz", "--log", "/no/where/a.mcap"), r"--log .*: expected .* in a folder"),
        ((PLANS / "go1.npz", "--interface", "wire0"), r"interface: expected one of .*lo"),
    ],
)
def test_what_is_refused_before_anything_moves(arguments, message, refused):
    if "wire0" in arguments:
        pytest.importorskip("cyclonedds", reason="needs the extra llsrbm[wire]")
    line = refused("deploy", *map(str, arguments))
    assert re.search(message, line), line


def test_a_plan_whose_certificate_does_not_hold_is_refused(tmp_path, refused):
    plan = llsrbm.load(PLANS / "go1.npz")
    replace(plan, contact_force=3 * plan.contact_force).save(tmp_path / "pushes.npz")
    message = r"plan: its certificate does not hold: \w+ .*as `llsrbm plan` makes"
    assert re.search(message, refused("deploy", str(tmp_path / "pushes.npz")))


@pytest.mark.parametrize(
    ("module", "message"),
    [
        ("cyclonedds", r"a robot's wire needs Cyclone DDS: pip install 'llsrbm\[wire\]'"),
        ("foxglove", r"the log of a play needs Foxglove's SDK: pip install 'llsrbm\[mcap\]'"),
    ],
)
def test_packages_that_are_missing(module, message, monkeypatch, refused):
    found = llsrbm.errors.find_spec
    monkeypatch.setattr(
        llsrbm.errors, "find_spec", lambda name: None if name == module else found(name)
    )
    assert re.search(message, refused("deploy", str(PLANS / "go1.npz")))


# ---- over DDS, in processes of their own


@pytest.fixture
def robot():
    """A simulated Go2 in a domain of its own; `ended` makes it end and gives its result."""
    pytest.importorskip("cyclonedds", reason="needs the extra llsrbm[wire]")
    domain = random.randrange(20, 200)
    with simulator(domain, "--robot", "go1") as ended:
        yield SimpleNamespace(domain=domain, ended=ended)


def deploy(robot, folder, *options):
    """A player in its own process."""
    command = [sys.executable, "-m", "llsrbm.cli", "deploy", str(PLANS / "go1.npz")]
    return subprocess.Popen(
        [*command, "--domain", str(robot.domain), "--tier", "table", *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(Path.cwd())},
    )


def until(process, state):
    """Read the lines of a player until it says that a state begins; False: it ended before."""
    return any(line.startswith(state) for line in iter(process.stdout.readline, ""))


def test_a_killed_player_leaves_a_robot_that_brakes(robot, tmp_path):
    player = deploy(robot, tmp_path)
    until(player, "ramp")
    time.sleep(0.3)  # until some commands were sent
    player.kill()
    player.wait()
    time.sleep(1.0)  # the robot's own time goes on: it brakes after 50 ms
    result = robot.ended()
    assert result["commands"] > 0
    assert result["braking"]


def test_ctrl_c_damps_and_leaves_a_log(robot, tmp_path):
    pytest.importorskip("foxglove", reason="needs the extra llsrbm[mcap]")
    from mcap.reader import make_reader

    player = deploy(robot, tmp_path, "--log", "play.mcap")
    until(player, "stand")
    player.send_signal(signal.SIGINT)
    _, err = player.communicate(timeout=STARTS)
    assert player.returncode == 1
    assert re.search(rf"^llsrbm: stopped in \w+ and damped: (Ctrl-C|{BUSY})", err), err
    assert err.count("\n") == 1
    with (tmp_path / "play.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    topics = {channel.topic for channel in summary.channels.values()}
    assert topics == {"/play", "/command", "/readings"}


def test_a_jump_over_dds(robot, tmp_path):
    player = deploy(robot, tmp_path, "--json", "--log", "play.mcap")
    out, err = player.communicate(timeout=STARTS)
    result = json.loads(out)
    if re.match(BUSY, result["reason"]):
        pytest.skip(f"the machine is busy: {result['reason']}")
    assert result["played"], err
    assert player.returncode == 0
    assert robot.ended()["touched"].count("base") <= 1  # as it lies down
