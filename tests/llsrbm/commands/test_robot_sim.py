"""`llsrbm robot-sim` as a command: its options, and mistakes in one line."""

import json
import random

import pytest

from llsrbm.cli import main
from llsrbm.commands.robot_sim import _surroundings
from llsrbm.errors import InputError
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.app.synthetic_plan import synthetic_plan

pytest.importorskip("cyclonedds", reason="needs the extra llsrbm[wire]")


def words(*arguments):
    domain = random.randrange(20, 200)
    return ["robot-sim", "--robot", "go2", "--domain", str(domain), *arguments]


def run(*arguments):
    return main(words(*arguments))


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


def test_it_hangs(capfd):
    assert run("--hung", "--duration", "0.1") == 0
    assert capfd.readouterr().out.startswith("Unitree Go2 hangs, interface lo, domain ")


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
def test_mistakes_are_told_in_one_line(arguments, message, refused):
    assert message in refused(*words(*arguments))


def test_it_stands_among_the_boxes_of_a_plan(tmp_path):
    go2, file = load_robot("go2"), tmp_path / "up.npz"
    synthetic_plan(Jump(robot="go2", forward=0.6, height=0.1)).save(file)
    around = _surroundings(file, go2)
    assert [block.name for block in around.blocks] == ["box"]
    assert around.ground == 0
    synthetic_plan(Jump(robot="go2", height=0.1)).save(file)
    with pytest.raises(InputError, match=r"The box comes in mid-flight.*expected a jump whose"):
        _surroundings(file, go2)
    synthetic_plan(Jump()).save(file)
    with pytest.raises(InputError, match=r"expected a plan of Unitree Go2, got anymal's"):
        _surroundings(file, go2)
