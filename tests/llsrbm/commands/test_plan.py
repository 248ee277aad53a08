"""`llsrbm plan`: exit status, one line for what is wrong, one JSON object when asked."""

import json
import math
import os
from dataclasses import replace

import numpy as np
import pytest

import llsrbm
from llsrbm import cli
from llsrbm.errors import InputError, NotConverged
from llsrbm.motion.trajectory import load
from tests.llsrbm.processes import run
from tests.llsrbm.synthetic import synthetic_plan

# As the contract has them, in its order.
PLAN_KEYS = [
    "status", "solver", "iterations", "guess", "solve_time_s", "total_time_s", "build_time_s",
    "cost", "compiling", "duration_s", "phase_durations_s", "peak_yaw_rate", "final_yaw",
    "model_turn", "refined", "refinement", "violations", "joint_torque_ratio", "power", "phases",
    "request", "certificate", "certified",
]  # fmt: skip


def test_options_become_a_request_in_radians(planner, capsys):
    words = "--robot anymal --model srbm --twist -90 --forward 0.2 --lateral -0.1 --height 0.1"
    assert cli.main(["plan", *words.split(), "--solver", "ipopt"]) == 0
    jump, options = planner.requests[0]
    assert jump == llsrbm.Jump("anymal", "srbm", -math.pi / 2, 0.2, -0.1, 0.1)
    assert options["solver"] == "ipopt"


@pytest.mark.parametrize(
    ("words", "jump"),
    [
        ("--type flip", llsrbm.Jump(type="flip", pitch=-math.tau)),
        ("--type flip --pitch 360", llsrbm.Jump(type="flip", pitch=math.tau)),
        ("--type barrel-roll --roll -360", llsrbm.Jump(type="barrel-roll", roll=-math.tau)),
        ("--type flip --roll -360", llsrbm.Jump(type="barrel-roll", roll=-math.tau)),
        ("--type hops", llsrbm.Jump(type="hops", hops=2)),
        ("--type hops --hops 3 --forward 0.2", llsrbm.Jump(type="hops", hops=3, forward=0.2)),
        ("--type run-up", llsrbm.Jump(type="run-up", speed=0.5)),
        (
            "--type run-up --speed 0.25 --end-speed 0.125",
            llsrbm.Jump(type="run-up", speed=0.25, end_speed=0.125),
        ),
        ("--speed 0.25", llsrbm.Jump(speed=0.25)),
        ("--arms held", llsrbm.Jump(arms="held")),
        ("--arms free", llsrbm.Jump()),
        (
            "--stone LF,0.04,0.02 --stone RH,-0.02,0,0.03",
            llsrbm.Jump(stones={"LF": (0.04, 0.02), "RH": (-0.02, 0.0, 0.03)}),
        ),
    ],
)
def test_a_silent_request_is_the_types(planner, words, jump):
    assert cli.main(["plan", *words.split()]) == 0
    assert planner.requests[0][0] == jump


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--type flipp", 'unknown jump type "flipp"; did you mean "flip"?'),
        ("--type none/such.toml", "none/such.toml: no such file; expected a jump type"),
        ("--pitch 90", "pitch: 90 deg; expected whole turns: -360, 0 or 360 deg"),
        ("--hops 9", "hops: expected 1 to 5, got 9"),
        ("--speed nan", "speed: expected a finite number, got nan"),
        ("--arms helt", 'arms: no choice "helt"; did you mean "held"? valid: free, held'),
    ],
)
def test_a_wrong_type_or_turn_is_bad_input(planner, words, said, refused):
    assert said in refused("plan", *words.split())
    assert not planner.requests


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            "barrel-roll --robot go2",
            'roll: the file of go2 allows pitch alone ("axes" of [turning]); robots that roll: ',
        ),
        (
            "hops --robot go2 --pitch 360",
            "pitch: jumps of type hops do not turn so; expected the t",
        ),
        ("flip --robot anymal", "anymal has no table [turning] in its file"),
    ],
)
def test_a_turn_that_the_robot_does_not_do_is_bad_input_at_once(words, said, refused):
    assert said in refused("plan", "--type", *words.split())


@pytest.mark.parametrize(("words", "draft"), [("", False), ("--draft", True)])
def test_a_draft_is_made_where_it_is_asked_for(planner, capsys, words, draft):
    assert cli.main(["plan", *words.split()]) == 0
    assert planner.requests[0][1]["draft"] is draft
    assert "a draft: its drives were looked at in knots only\n" in capsys.readouterr().out


def test_types_are_listed(capsys):
    assert cli.main(["types"]) == 0
    rows = dict(line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    assert next(iter(rows)) == "together"
    assert rows["flip"].endswith("(--pitch -360)")
    assert rows["barrel-roll"].endswith("(--roll 360)")
    assert rows["run-up"].endswith("(--speed 0.5, --end-speed)")


def test_json_is_one_object_with_the_contracts_keys(planner, capfd):
    plan = synthetic_plan(twist=-math.pi)
    planner.answers[0] = plan
    assert cli.main(["plan", "--json"]) == 0
    out, err = capfd.readouterr()
    assert out.count("\n") == 1
    result = json.loads(out)
    assert list(result) == PLAN_KEYS
    assert result["status"] == "solved"
    assert result["phase_durations_s"] == pytest.approx([0.5, 0.4, 0.6])
    assert result["final_yaw"] == pytest.approx(-math.pi)
    assert result["peak_yaw_rate"] == pytest.approx(1.5 * math.pi / 1.5, rel=1e-2)
    assert result["violations"] == {"friction": 2e-5, "reach": 0.0}
    shares = np.abs(plan.joint_torque) / plan.joint_torque_limit
    assert result["joint_torque_ratio"] == pytest.approx(
        dict(zip(plan.joint_names, shares.max(axis=0)))
    )
    legs = ["LF", "RF", "LH", "RH"]
    assert [(phase["name"], phase["feet"]) for phase in result["phases"]] == [
        ("take-off", legs),
        ("flight", []),
        ("landing", legs),
    ]
    durations = [phase["duration_s"] for phase in result["phases"]]
    assert durations == result["phase_durations_s"]
    assert result["request"] == planner.requests[0][0].as_dict()
    assert "a banner of a solver" in err


def test_json_keeps_compiled_libraries_off_stdout(planner, capfd, monkeypatch):
    inner = llsrbm.plan

    def noisy(jump, **options):
        os.write(1, b"printed from C\n")
        return inner(jump, **options)

    monkeypatch.setattr(llsrbm, "plan", noisy)
    assert cli.main(["plan", "--json"]) == 0
    out, err = capfd.readouterr()
    json.loads(out)
    assert "printed from C" in err


def test_not_converged_is_exit_1_with_the_plan(planner, capfd, tmp_path):
    plan = synthetic_plan()
    report = replace(plan.report, status="not-converged", cost=math.nan)
    plan = replace(plan, report=report)
    said = "friction is violated by 3 N in the landing"
    planner.answers[0] = NotConverged(said, plan)
    assert cli.main(["plan", "--json", "--out", str(tmp_path / "p.npz")]) == 1
    out, err = capfd.readouterr()
    result = json.loads(out, parse_constant=pytest.fail)
    assert result["status"] == "not-converged"
    assert result["cost"] is None
    assert (result["certificate"], result["certified"]) == (None, False)
    assert err.splitlines()[-1] == f"llsrbm: {said}"
    assert not load(tmp_path / "p.npz").solved


def test_summary_for_a_person(planner, capsys):
    assert cli.main(["plan", "--twist", "90"]) == 0
    out = capsys.readouterr().out
    assert "llsrbm-plus: twist 90°, forward 0.00 m, lateral 0.00 m, height 0.00 m\n" in out
    assert "1.50 s = take-off 0.50 + flight 0.40 + landing 0.60\n" in out
    assert "14 iterations" in out
    assert " of 40 Nm in " in out
    assert "fastest" in out
    assert "2.0e−05 N, landing at 1.10 s (friction)" in out


def test_the_planners_refusal_is_exit_2(planner, capsys):
    planner.answers[0] = InputError("forward 50 m\nis out of range")
    assert cli.main(["plan"]) == 2
    assert capsys.readouterr().err == "llsrbm: forward 50 m is out of range\n"


def test_for_real(tmp_path):
    process = run("plan", "--twist", 30, "--draft", "--json", "--out", tmp_path / "plan.npz")
    assert process.returncode == 0, process.stderr
    result = json.loads(process.stdout)
    assert result["status"] == "solved"
    assert result["final_yaw"] == pytest.approx(math.radians(30), abs=1e-3)
    assert max(result["violations"].values()) < 1e-3
    assert all(0.1 < share < 2.0 for share in result["joint_torque_ratio"].values())
    plan = load(tmp_path / "plan.npz")
    assert plan.jump.twist == pytest.approx(math.radians(30))
    out = str(tmp_path / "plan.csv")
    assert cli.main(["export", str(tmp_path / "plan.npz"), "--format", "csv", "--out", out]) == 0
    table = np.loadtxt(tmp_path / "plan.csv", delimiter=",", skiprows=1)
    assert table[-1, 0] == pytest.approx(plan.duration)


@pytest.mark.parametrize(
    ("out", "said"),
    [
        ("nowhere/p.npz", "no such directory"),
        (".", "it is a directory"),
        ("x" * 5000, "File name too long"),
        ("/proc/p.npz", "cannot write /proc/p.npz"),
    ],
)
def test_where_nothing_can_be_written_is_told_before_the_plan_is_made(
    planner, tmp_path, monkeypatch, capsys, out, said
):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["plan", "--out", out]) == 2
    err = capsys.readouterr().err
    assert said in err
    assert err.count("\n") == 1
    assert not planner.requests


@pytest.mark.parametrize("option", ["--weight", "--limit"])
def test_a_name_that_is_given_twice_is_refused(planner, capsys, option):
    name = "tilt" if option == "--weight" else "friction"
    assert cli.main(["plan", option, f"{name}=0.3", option, f"{name} = 0.4"]) == 2
    assert f"{option} {name} = 0.4: {name} is given twice" in capsys.readouterr().err


def test_a_path_that_is_too_long_is_one_line_of_bad_input(capsys):
    assert cli.main(["robot", "new", "x" * 5000]) == 2
    err = capsys.readouterr().err
    assert "xxx...: File name too long" in err
    assert len(err) < 500
