"""The command line: exit status, one line for what is wrong, one JSON object when asked."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from dataclasses import replace
from importlib.metadata import EntryPoint

import numpy as np
import pytest

import llsrbm
from llsrbm import cli
from llsrbm.errors import InputError, NotConverged
from llsrbm.trajectory.files import load
from tests.llsrbm.synthetic import synthetic_plan

# As the contract has them, in its order.
PLAN_KEYS = [
    "status", "solver", "iterations", "solve_time_s", "total_time_s", "build_time_s", "cost",
    "duration_s", "phase_durations_s", "peak_yaw_rate", "final_yaw", "violations",
]  # fmt: skip


def run(*arguments, **options):
    """`llsrbm` in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "llsrbm.cli", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=100,
        **options,
    )


def assert_one_line(process, status):
    assert process.returncode == status, process.stderr
    assert process.stdout == ""
    assert process.stderr.count("\n") == 1, process.stderr
    assert process.stderr.startswith("llsrbm: ")


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    path = tmp_path_factory.mktemp("cli") / "plan.npz"
    synthetic_plan().save(path)
    return path


@pytest.fixture
def planner(monkeypatch):
    """`llsrbm.plan` that answers at once with the plan or the error put into the list."""
    answers, requests = [], []

    def plan(jump, **options):
        requests.append((jump, options))
        print("a banner of a solver")
        if isinstance(answers[0], Exception):
            raise answers[0]
        return replace(answers[0], jump=jump)

    monkeypatch.setattr(llsrbm, "plan", plan)
    plan.answers, plan.requests = answers, requests
    return plan


class TestBadInput:
    @pytest.mark.parametrize(
        ("arguments", "said"),
        [
            (["plan", "--robot", "nosuch"], "anymal"),
            (["plan", "--twist", "abc"], "--twist"),
            (["plan", "--forward", "50", "--json"], "50 m is out of range"),
        ],
    )
    def test_in_a_process(self, arguments, said, tmp_path):
        """Where a traceback or a stray print would show."""
        process = run(*arguments, cwd=tmp_path)
        assert_one_line(process, 2)
        assert said in process.stderr
        assert list(tmp_path.iterdir()) == []

    @pytest.mark.parametrize(
        ("arguments", "said"),
        [
            (["nosuch"], 'no command "nosuch"; the commands are plan, simulate, export, robots, models'),
            (["plan", "--twist", "nan"], "finite number"),
            (["plan", "--model", "nosuch"], "srbm, llsrbm, llsrbm-plus"),
            (["plan", "--solver", "nosuch"], "fatrop"),
            (["plan", "--forward", "50"], "50 m is out of range"),
            (["plan", "--twist", "400"], "400 deg is out of range"),
            (["plan", "--nosuch"], "--nosuch"),
            (["plan", "extra"], "extra"),
            (["export"], "FILE.npz"),
            (["export", "nosuch.npz", "--format", "csv", "--out", "x"], "No such file"),
        ],
    )
    def test_is_one_line_and_exit_2(self, arguments, said, capfd, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        assert cli.main(arguments) == 2
        out, err = capfd.readouterr()
        assert out == ""
        assert err.startswith("llsrbm: ")
        assert err.count("\n") == 1
        assert said in err
        assert list(tmp_path.iterdir()) == []

    def test_unreadable_npz(self, tmp_path):
        (tmp_path / "bad.npz").write_bytes(b"PK\x03\x04 no more")
        process = run("export", tmp_path / "bad.npz", "--format", "csv", "--out", tmp_path / "x")
        assert_one_line(process, 2)
        assert "not an npz file" in process.stderr

    def test_export_options(self, saved, tmp_path, capfd):
        for options, said in (
            (["--format", "bvh", "--out", "x"], "the formats are npz, csv"),
            (["--format", "csv", "--fps", "0", "--out", "x"], "0 < fps"),
            (["--format", "csv", "--out", str(tmp_path / "none" / "x.csv")], "cannot write"),
        ):
            assert cli.main(["export", str(saved), *options]) == 2
            out, err = capfd.readouterr()
            assert (out, err.count("\n")) == ("", 1)
            assert said in err


class TestLists:
    def test_help_imports_nothing_heavy(self):
        code = (
            "import sys; from llsrbm import cli; cli.main(['--help']);"
            "heavy = {'casadi', 'pinocchio', 'mujoco', 'viser', 'numpy'} & set(sys.modules);"
            "sys.exit(', '.join(heavy) or 0)"
        )
        process = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
        assert process.returncode == 0, process.stderr

    def test_help_without_arguments(self, capsys):
        assert cli.main([]) == 0
        out = capsys.readouterr().out
        assert all(word in out for word in ("plan", "export", "robots", "models", "formats"))

    def test_robots_models_formats(self, capsys):
        for command, first in (("robots", "anymal"), ("models", "srbm"), ("formats", "npz")):
            assert cli.main([command]) == 0
            lines = capsys.readouterr().out.splitlines()
            assert lines[0].split()[0] == first

    def test_version(self, capsys):
        assert cli.main(["--version"]) == 0
        assert capsys.readouterr().out.strip()

    def test_a_reader_that_goes_away_is_no_traceback(self):
        reading, writing = os.pipe()
        os.close(reading)
        process = subprocess.run(
            [sys.executable, "-m", "llsrbm.cli", "models"], stdout=writing, stderr=subprocess.PIPE
        )
        os.close(writing)
        assert process.stderr == b""
        assert process.returncode == 1


class TestPlan:
    def test_options_become_a_request_in_radians(self, planner, capsys):
        planner.answers.append(synthetic_plan())
        words = "--robot anymal --model srbm --twist -90 --forward 0.2 --lateral -0.1 --height 0.1"
        assert cli.main(["plan", *words.split(), "--solver", "ipopt"]) == 0
        jump, options = planner.requests[0]
        assert jump == llsrbm.Jump("anymal", "srbm", -math.pi / 2, 0.2, -0.1, 0.1)
        assert options["solver"] == "ipopt"

    def test_json_is_one_object_with_the_contracts_keys(self, planner, capfd):
        plan = synthetic_plan(twist=-math.pi)
        planner.answers.append(plan)
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
        assert "a banner of a solver" in err

    def test_json_keeps_compiled_libraries_off_stdout(self, planner, capfd, monkeypatch):
        planner.answers.append(synthetic_plan())
        inner = llsrbm.plan

        def noisy(jump, **options):
            os.write(1, b"printed from C\n")
            return inner(jump, **options)

        monkeypatch.setattr(llsrbm, "plan", noisy)
        assert cli.main(["plan", "--json"]) == 0
        out, err = capfd.readouterr()
        json.loads(out)
        assert "printed from C" in err

    def test_not_converged_is_exit_1_with_the_plan(self, planner, capfd, tmp_path):
        plan = synthetic_plan()
        report = replace(plan.report, status="not-converged", cost=math.nan)
        plan = replace(plan, report=report)
        said = "friction is violated by 3 N in the landing"
        planner.answers.append(NotConverged(said, plan))
        assert cli.main(["plan", "--json", "--out", str(tmp_path / "p.npz")]) == 1
        out, err = capfd.readouterr()
        result = json.loads(out, parse_constant=pytest.fail)
        assert result["status"] == "not-converged"
        assert result["cost"] is None
        assert err.splitlines()[-1] == f"llsrbm: {said}"
        assert not load(tmp_path / "p.npz").solved

    def test_out_is_what_the_planner_returned(self, planner, tmp_path, capsys):
        plan = synthetic_plan()
        planner.answers.append(plan)
        assert cli.main(["plan", "--out", str(tmp_path / "p.npz")]) == 0
        np.testing.assert_array_equal(load(tmp_path / "p.npz").com, plan.com)

    def test_summary_for_a_person(self, planner, capsys):
        planner.answers.append(synthetic_plan())
        assert cli.main(["plan", "--twist", "90"]) == 0
        out = capsys.readouterr().out
        assert "twist 90 deg" in out
        assert "14 iterations" in out
        assert "fastest" in out
        assert "2.0e-05 N (friction, landing, 1.10 s)" in out

    def test_the_planners_refusal_is_exit_2(self, planner, capsys):
        planner.answers.append(InputError("forward 50 m\nis out of range"))
        assert cli.main(["plan"]) == 2
        assert capsys.readouterr().err == "llsrbm: forward 50 m is out of range\n"

    def test_interrupt(self, monkeypatch):
        def interrupted(*_args, **_kwargs):
            raise KeyboardInterrupt

        monkeypatch.setattr(llsrbm, "plan", interrupted)
        assert cli.main(["plan"]) == 130

    def test_for_real(self, tmp_path):
        process = run("plan", "--twist", 30, "--json", "--out", tmp_path / "plan.npz")
        assert process.returncode == 0, process.stderr
        result = json.loads(process.stdout)
        assert result["status"] == "solved"
        assert result["final_yaw"] == pytest.approx(math.radians(30), abs=1e-3)
        assert max(result["violations"].values()) < 1e-3
        plan = load(tmp_path / "plan.npz")
        assert plan.jump.twist == pytest.approx(math.radians(30))
        process = run(
            "export", tmp_path / "plan.npz", "--format", "csv", "--out", tmp_path / "plan.csv"
        )
        assert process.returncode == 0, process.stderr
        table = np.loadtxt(tmp_path / "plan.csv", delimiter=",", skiprows=1)
        assert table[-1, 0] == pytest.approx(plan.duration)


class TestCommandsOfOtherPackages:
    def register(self, monkeypatch, value):
        point = EntryPoint(name="greet", value=value, group="llsrbm.commands")
        monkeypatch.setattr(cli, "entry_points", lambda group: (point,))

    def test_are_found_and_get_their_options(self, monkeypatch, capsys):
        self.register(monkeypatch, "tests.llsrbm.plugin:greet")
        assert cli.main(["greet", "--name", "Anna"]) == 0
        assert capsys.readouterr().out == "hello Anna\n"
        assert cli.main(["--help"]) == 0
        assert "Say hello." in capsys.readouterr().out

    def test_their_mistakes_are_one_line_too(self, monkeypatch, capsys):
        self.register(monkeypatch, "tests.llsrbm.plugin:greet")
        assert cli.main(["greet", "--times", "x"]) == 2
        assert capsys.readouterr().err.count("\n") == 1
        assert cli.main(["greet", "--name", "nobody"]) == 2
        assert capsys.readouterr().err == "llsrbm: nobody is not somebody\n"

    def test_that_cannot_be_loaded(self, monkeypatch, capsys):
        self.register(monkeypatch, "tests.llsrbm.nosuch:greet")
        assert cli.main(["greet"]) == 1
        assert 'command "greet" (tests.llsrbm.nosuch:greet)' in capsys.readouterr().err
