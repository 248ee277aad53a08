"""The designs that come with the project; whether they land is for `benchmarks/examples.py`."""

import pytest

from llsrbm import models
from llsrbm.errors import InputError
from llsrbm.installed import assets_directory
from llsrbm.planning.problem.placement import make_task
from llsrbm.request.design import dump_design, examples, find_design, load_design
from llsrbm.robots import load_robot, names
from llsrbm.simulation.checks import check_scenario

EXAMPLES = examples()
FILES = sorted((assets_directory() / "designs").iterdir())


def test_the_papers_experiments_come_first():
    asked = [design.jump for design in EXAMPLES.values()][:5]
    assert [(jump.robot, jump.forward, jump.height) for jump in asked] == [
        ("anymal", 0, 0), ("slider", 0, 0), ("anymal", 0, 0), ("anymal", 0.3, 0),
        ("slider", 0.2, 0.35),
    ]  # fmt: skip
    assert [round(jump.twist, 4) for jump in asked] == [1.5708, 1.5708, 0.5236, 0, 0]
    assert EXAMPLES["anymal-board"].scenario.board == 0.025


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_an_examples_file_is_as_it_would_be_saved(path):
    assert path.read_text() == dump_design(load_design(path))


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_is_within_what_may_be_asked(name):
    design = find_design(name)
    jump, scenario = design.jump, design.scenario
    assert jump.robot in names()
    assert jump.model in models.MODELS
    robot = load_robot(jump.robot)
    make_task(jump, robot, design.tuning.weights, design.tuning.limits)
    check_scenario(scenario, robot)
    assert scenario.board <= robot.file.limits.clearance


def test_an_unknown_name_is_answered_with_the_known_ones():
    with pytest.raises(InputError, match=r'no design "box"; .*valid: anymal-twist, slider-twist'):
        find_design("box")
