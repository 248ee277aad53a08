"""`llsrbm largest`: lines, one JSON object, exit status, the plan's file."""

import json
import math
from dataclasses import replace

import pytest

import llsrbm
from llsrbm import cli
from llsrbm.errors import NotConverged
from llsrbm.largest_jump import Largest
from tests.llsrbm.player.stages import stored_plan

LIMIT = "RR_calf_joint is at its limit of 15.7 rad/s at lift-off"


@pytest.fixture
def searched(monkeypatch):
    """`llsrbm.largest` that answers at once, or raises the error put first into the list."""
    answers, requests = [], []

    def largest(jump, component, *, weights, limits, progress):
        requests.append((jump, component, weights, limits))
        print("a banner of a solver")
        if answers:
            raise answers[0]
        unit, value = ("rad", math.pi) if component == "twist" else ("m", 0.7)
        name = {"twist": "twist"}.get(component, "forward")
        plan = replace(stored_plan(), jump=replace(jump, **{name: value}))
        return Largest(component, value, unit, LIMIT, plan)

    monkeypatch.setattr(llsrbm, "largest", largest)
    largest.answers, largest.requests = answers, requests
    return largest


def test_json_is_one_object_in_si_units(searched, capfd):
    words = "--robot go2 --component twist --lateral 0.1 --limit friction=0.5 --json"
    assert cli.main(["largest", *words.split()]) == 0
    found = json.loads(capfd.readouterr().out)
    assert {name: found[name] for name in ("robot", "component", "value", "unit", "limit")} == {
        "robot": "go2", "component": "twist", "value": math.pi, "unit": "rad", "limit": LIMIT,
    }  # fmt: skip
    assert found["request"]["twist"] == math.pi
    jump = llsrbm.Jump(robot="go2", lateral=0.1)
    assert searched.requests == [(jump, "twist", {}, {"friction": 0.5})]


@pytest.mark.parametrize(
    ("component", "words"), [("twist", "twist 180°"), ("forward", "forward 0.70 m")]
)
def test_lines_are_in_degrees_and_metres(searched, capsys, component, words):
    assert cli.main(["largest", "--robot", "go2", "--component", component]) == 0
    out = capsys.readouterr().out
    assert f"Largest  {words}\n" in out
    assert f"Limit    {LIMIT}\n" in out


def test_the_plan_is_written(searched, tmp_path):
    path = tmp_path / "largest.npz"
    words = ["largest", "--robot", "go2", "--component", "forward", "--out", str(path)]
    assert cli.main(words) == 0
    plan = llsrbm.load(path)
    assert plan.jump.forward == 0.7  # out of the range of the robot's file
    assert plan.feedback_gain is not None


def test_where_there_is_none_the_exit_status_is_1(searched, capfd):
    searched.answers.append(NotConverged("no jump to begin from: why", None, reason="why"))
    assert cli.main(["largest", "--component", "up", "--json"]) == 1
    out, err = capfd.readouterr()
    assert json.loads(out) == {
        "robot": "anymal", "component": "up", "value": None, "unit": "m", "limit": "why",
    }  # fmt: skip
    assert "llsrbm: no jump to begin from: why\n" in err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("--robot go2", "Missing option '--component'"),
        ("--robot go2 --component far", 'no component "far"'),
        ("--robot go2 --component up --type flip", "turn over"),
        ("--robot go2 --component up --twist 900", "twist 900 deg is out of range"),
    ],
)
def test_bad_input_is_one_line(capfd, words, message):
    assert cli.main(["largest", *words.split()]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert message in err
    assert err.count("\n") == 1
