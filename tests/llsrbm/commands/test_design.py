"""`--design` and `llsrbm designs`: a file's values count unless an option says otherwise."""

import math
from dataclasses import replace

import pytest

from llsrbm import cli
from llsrbm.request.design import Design, dump_design, examples
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from llsrbm.request.tuning import Tuning

DESIGN = Design(
    Jump("go2", "srbm", twist=0.5, forward=0.2),
    Tuning(weights={"time": 3.0}, limits={"friction": 0.4}),
    Scenario(board=0.02, half_board=True, seed=7, noise=0.5, detector="norm"),
)


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "mine.jump.json"
    path.write_text(dump_design(DESIGN))
    return str(path)


def test_a_design_is_planned(planner, file, capsys):
    assert cli.main(["plan", "--design", file]) == 0
    jump, options = planner.requests[0]
    assert jump == DESIGN.jump
    assert (options["weights"], options["limits"]) == ({"time": 3.0}, {"friction": 0.4})


def test_options_override_a_design_even_with_a_default(planner, file, capsys):
    words = "--robot anymal --twist 0 --height 0.1"
    assert cli.main(["plan", *words.split(), "--design", file]) == 0
    assert planner.requests[0][0] == Jump("anymal", "srbm", forward=0.2, height=0.1)


@pytest.mark.parametrize(
    ("words", "changes"),
    [
        ("--forward 0.1", {"forward": 0.1}),  # it stays a front flip
        ("--type hops", {"type": "hops", "pitch": 0.0, "hops": 2}),
        ("--type flip", {"pitch": -math.tau}),
    ],
)
def test_options_override_a_designs_type(planner, tmp_path, words, changes, capsys):
    flip = Jump("go2", type="flip", pitch=math.tau, forward=0.2)
    path = tmp_path / "flip.jump.json"
    path.write_text(dump_design(Design(flip)))
    assert cli.main(["plan", "--design", str(path), *words.split()]) == 0
    assert planner.requests[0][0] == replace(flip, **changes)


def test_a_design_is_simulated_in_its_scenario(planner, simulator, file, capsys):
    assert cli.main(["simulate", "--design", file]) == 0
    assert planner.requests[0][0] == DESIGN.jump
    assert planner.requests[0][1]["limits"] == {"friction": 0.4}
    assert simulator.requests[0][1] == DESIGN.scenario


@pytest.mark.parametrize(
    ("flag", "drives"), [("--ideal-drives", "ideal"), ("--true-drives", "true")]
)
def test_ideal_drives_are_a_flag(planner, simulator, tmp_path, flag, drives, capsys):
    path = tmp_path / "other.jump.json"
    other = {"ideal": "true", "true": "ideal"}[drives]
    path.write_text(dump_design(replace(DESIGN, scenario=Scenario(seed=7, drives=other))))
    assert cli.main(["simulate", flag, "--design", str(path)]) == 0
    assert simulator.requests[0][1] == Scenario(seed=7, drives=drives)


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["plan", "--design", "slider-bok"], 'no design "slider-bok"; did you mean "slider-box"?'),
        (["plan", "--design", "a.json"], "a.json: cannot be read (No such file or directory)"),
        (["simulate", "--design", "./a"], "./a: cannot be read (No such file or directory)"),
        (["simulate", "p.npz", "--design", "slider-box"], "--design: is for planning, but p.npz"),
        (["simulate", "p.npz", "--stone", "LF,0.1,0"], "--stone: is for planning, but p.npz"),
    ],
)
def test_what_is_no_design_is_one_line(planner, arguments, complaint, refused):
    assert refused(*arguments).startswith(complaint)
    assert not planner.requests


def test_designs_are_listed(capsys):
    assert cli.main(["designs"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "anymal-twist       Paper: ANYmal, 90° twist"
    assert len(lines) == len(examples())
