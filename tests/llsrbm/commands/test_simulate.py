"""`llsrbm simulate`: a file or a jump, exit status, one JSON object when asked."""

import json
import math
import re
from dataclasses import asdict, replace

import numpy as np
import pytest

import llsrbm
from llsrbm import cli
from llsrbm.analysis.diagnosis import diagnose
from llsrbm.analysis.summaries import rollout_summary
from llsrbm.analysis.wording import rollout_rows
from llsrbm.errors import NotConverged
from llsrbm.motion.trajectory import load
from llsrbm.request.scenario import Push, Scenario
from tests.llsrbm.processes import run
from tests.llsrbm.synthetic import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout


def test_a_file_is_simulated_as_it_is(simulator, saved, capsys, tmp_path):
    words = "--board 0.025 --half-board --seed 7 --noise 0.5 --detector norm --landing planned"
    words += " --trunk-mass -0.12"
    out = tmp_path / "r.npz"
    command = ["simulate", str(saved), *words.split(), "--qp-solver", "quadprog"]
    assert cli.main([*command, "--out", str(out)]) == 0
    (plan, scenario), *_ = simulator.requests
    np.testing.assert_array_equal(plan.com, synthetic_plan().com)
    assert scenario == Scenario(0.025, True, 7, 0.5, "norm", "planned", "quadprog", -0.12)
    np.testing.assert_array_equal(load(out).qpos, simulator.answers[0].qpos)


def test_pushes_are_repeated_options(simulator, saved, capsys):
    words = "--push 0.4,0,12,0 --push 0.5,1,2,3,-1,-2,-3 --random-push 8 --estimator drift --replan"
    words += " --replan-latency measured"
    assert cli.main(["simulate", str(saved), *words.split()]) == 0
    assert simulator.requests[0][1] == Scenario(
        pushes=(Push(0.4, (0, 12, 0)), Push(0.5, (1, 2, 3), (-1, -2, -3))),
        random_push=8.0,
        estimator="drift",
        replan=True,
        replan_latency="measured",
    )


def test_without_a_file_the_jump_is_planned_first(planner, simulator, capsys):
    words = "--robot anymal --model srbm --twist -90 --forward 0.2 --lateral -0.1 --height 0.1"
    assert cli.main(["simulate", *words.split(), "--solver", "ipopt"]) == 0
    jump, options = planner.requests[0]
    assert jump == llsrbm.Jump("anymal", "srbm", -math.pi / 2, 0.2, -0.1, 0.1)
    assert options["solver"] == "ipopt"
    plan, scenario = simulator.requests[0]
    assert plan.jump == jump
    assert scenario == Scenario()


def test_a_jump_that_cannot_be_planned_is_one_json_object_too(planner, simulator, capfd):
    """There was none on stdout, where --json promises one."""
    plan = synthetic_plan()
    failed = replace(plan, report=replace(plan.report, status="not-converged", cost=math.nan))
    planner.answers[0] = NotConverged("no plan found", failed)
    assert cli.main(["simulate", "--json"]) == 1
    printed = capfd.readouterr()
    assert json.loads(printed.out)["status"] == "not-converged"
    assert printed.err.endswith("llsrbm: no plan found\n")
    assert not simulator.requests


@pytest.mark.parametrize(("words", "said"), [((), True), (("--draft",), False)])
def test_a_draft_that_was_not_asked_for_is_told(planner, simulator, capsys, words, said):
    assert cli.main(["simulate", *words]) == 0
    assert planner.requests[0][1]["draft"] is bool(words)
    remark = "llsrbm: the plan is a draft: its drives were looked at in knots only\n"
    assert (remark in capsys.readouterr().err) is said


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--board -1", "board: expected 0 to 1 m, got -1"),
        ("--push 0.4,1", "push: expected T,JX,JY,JZ[,MX,MY,MZ] in s, N s and N m s, got '0.4,1'"),
        ("--push 0.4,0,0,0,nan,0,0", "push: moment: expected three finite numbers, got [nan"),
        ("--push 0.4,1e6,0,0", "push: impulse: expected at most 200 N s, got 1e+06 N s"),
        ("--random-push nan", "random push: expected a finite number, got nan"),
        ("--detector nosuch", 'no detector "nosuch"; valid: residual, norm'),
        ("--qp-solver nosuch", 'no QP solver "nosuch"'),
    ],
)
def test_what_makes_no_sense_is_refused_before_planning(planner, words, said, refused):
    assert refused("simulate", *words.split()).startswith(said)
    assert not planner.requests


@pytest.mark.parametrize("words", ["--twist 30", "--robot anymal", "--solver fatrop"])
def test_a_file_and_a_jump_contradict_each_other(words, simulator, saved, refused):
    """Even where the option says what is the default."""
    line = refused("simulate", str(saved), *words.split())
    assert line.startswith(f"{words.split()[0]}: ")
    assert not simulator.requests


def test_a_rollout_is_no_plan(simulator, tmp_path, refused):
    path = str(tmp_path / "r.npz")
    synthetic_rollout().save(path)
    assert refused("simulate", path) == f"{path}: holds a rollout; expected a plan\n"


def test_json_is_one_object(simulator, saved, capfd):
    rollout = synthetic_rollout(seed=7)
    simulator.answers[0] = rollout
    assert cli.main(["simulate", str(saved), "--json"]) == 0
    out, err = capfd.readouterr()
    assert out.count("\n") == 1
    assert json.loads(out, parse_constant=pytest.fail) == rollout_summary(rollout)
    assert "a banner of a simulator" in err


def test_a_fall_is_exit_1_with_when_and_why(simulator, saved, capfd, tmp_path):
    simulator.answers[0] = synthetic_rollout(fell_at=1.25)
    out_file = tmp_path / "r.npz"
    assert cli.main(["simulate", str(saved), "--json", "--out", str(out_file)]) == 1
    out, err = capfd.readouterr()
    assert json.loads(out)["status"] == "fell"
    assert json.loads(out)["fell_at_s"] == 1.25
    last = err.splitlines()[-1]
    events = diagnose(simulator.answers[0])
    assert last == (
        f"llsrbm: the robot fell at 1.25 s: first {events[0].words} ({events[0].time:.2f} s), "
        "then the base touched the ground at 1.25 s"
    )
    assert json.loads(out)["events"] == [asdict(event) for event in events]
    assert not load(out_file).landed


def test_summary_for_a_person(simulator, saved, capsys):
    scenario = Scenario(board=0.025, half_board=True, seed=7)
    simulator.answers[0] = replace(synthetic_rollout(), scenario=scenario)
    assert cli.main(["simulate", str(saved)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    _, *lines = out.splitlines()
    shown = [re.split("  +", line, maxsplit=1) for line in lines]
    assert [name for name, _ in shown[:2]] == ["Request", "Outcome"]
    assert dict(shown[2:]) == dict(rollout_rows(simulator.answers[0]))


def test_a_waiting_person_sees_how_far_it_is(simulator, saved, capsys, monkeypatch):
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    assert cli.main(["simulate", str(saved)]) == 0
    assert "simulating  50 %" in capsys.readouterr().err


def test_for_real(tmp_path):
    out = tmp_path / "rollout.npz"
    process = run("simulate", "--twist", 30, "--draft", "--seed", 3, "--json", "--out", out)
    assert process.returncode == 0, process.stderr
    result = json.loads(process.stdout)
    assert result["status"] == "landed"
    assert result["control_rate_hz"] == 400
    rollout = load(out)
    assert rollout.jump.twist == pytest.approx(math.radians(30))
    assert rollout_summary(rollout) == result
