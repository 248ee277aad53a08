"""`llsrbm robot-sim` as a command: its options, and mistakes in one line."""

import json
import random

import pytest

from llsrbm.cli import main

pytest.importorskip("cyclonedds", reason="needs the extra llsrbm[wire]")


def run(*arguments):
    domain = random.randrange(20, 200)
    return main(["robot-sim", "--domain", str(domain), *arguments])


def test_it_stands_for_as_long_as_it_is_asked_to(capfd):
    assert run("--duration", "0.2", "--json") == 0
    result = json.loads(capfd.readouterr().out)
    assert result["time_s"] == 0.2
    assert result["ticks"] == 100
    assert result["commands"] == 0
    assert result["touched"] == ""
    assert not result["braking"]


def test_its_lines(capfd):
    assert run("--robot", "g1", "--duration", "0.02", "--no-battery", "--lost", "0.5") == 0
    out = capfd.readouterr().out.splitlines()
    assert out[0].startswith("Unitree G1 stands, interface lo, domain ")
    assert "of 10 ticks began late" in out[1]
    assert out[-1] == "touched   nothing but feet touched anything"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--robot", "anymal"], "no table [wire]"),
        (["--robot", "solo12"], "expected unitree_go or unitree_hg"),
        (["--interface", "wire0"], "interface: expected one of"),
        (["--lost", "2"], "lost: expected a share of 0 to 1, got 2"),
        (["--delay-ms", "-1"], "delay: expected 0 to 1 s, got -0.001"),
        (["--duration", "0"], "duration: expected more than 0 s, got 0"),
        (["--plan", "none.npz"], "none.npz"),
    ],
)
def test_mistakes_are_told_in_one_line(arguments, message, capfd):
    assert run(*arguments) == 2
    err = capfd.readouterr().err
    assert message in err
    assert err.count("\n") == 1
