"""Files of the library that an addition touches: its own, and at most a line of a registry."""

import re
from pathlib import Path

import pytest

import llsrbm
from llsrbm.formats import FORMATS
from llsrbm.planning.problem.constraints import CONSTRAINTS
from llsrbm.planning.problem.costs import COSTS
from llsrbm.robots import names

FOLDER = Path(llsrbm.__file__).parent
SOURCES = {
    path.relative_to(FOLDER).as_posix(): path.read_text("utf-8") for path in FOLDER.rglob("*.py")
}


def files_with(pattern):
    return {name for name, source in SOURCES.items() if re.search(pattern, source)}


def own_file(thing):
    return type(thing).__module__.removeprefix("llsrbm.").replace(".", "/") + ".py"


@pytest.mark.parametrize("thing", CONSTRAINTS, ids=lambda each: each.name)
def test_a_constraint_is_a_class_and_a_line(thing):
    """The certificate, which shares nothing with the planner, has checks of the same names."""
    registry = "planning/problem/constraints/__init__.py"
    found = files_with(rf"\b{type(thing).__name__}\(\)") - {"certificate/certificate.py"}
    assert found <= {own_file(thing), registry}


@pytest.mark.parametrize("thing", COSTS, ids=lambda each: each.name)
def test_a_cost_is_one_file(thing):
    assert files_with(f'"{re.escape(thing.effect)}"') == {"planning/problem/costs.py"}


@pytest.mark.parametrize("name", sorted(set(names()) - {"anymal", "slider"}))
def test_a_robot_touches_no_module(name):
    assert files_with(f'"{name}"') == set()


@pytest.mark.parametrize("name", ["mimickit-pkl", "gmr-pkl", "unitree-csv", "mujoco"])
def test_a_format_is_its_own_module_and_a_line(name):
    assert len(files_with(f'"{name}"')) <= 2, files_with(f'"{name}"')
    assert name in FORMATS
