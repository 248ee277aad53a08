"""`llsrbm compare`: rows and columns, JSON, files that are none."""

import json
from dataclasses import asdict, replace

import pytest

from llsrbm import cli
from llsrbm.analysis.figure_table import FIGURES
from llsrbm.analysis.figures import figures_of_plan, figures_of_rollout
from tests.llsrbm.synthetic import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout

SLOW, FAST = synthetic_plan(), synthetic_plan(twist=0.5)
FAST = replace(FAST, report=replace(FAST.report, solve_time_s=0.04))
FELL = synthetic_rollout(fell_at=1.25, seed=7)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("compare")
    named = {"slow.npz": SLOW, "fast.npz": FAST, "fell.npz": FELL}
    for name, trajectory in named.items():
        trajectory.save(folder / name)
    return {name.removesuffix(".npz"): str(folder / name) for name in named}


def compared(capfd, *arguments):
    assert cli.main(["compare", *arguments]) == 0
    out, err = capfd.readouterr()
    assert err == ""
    return out


def test_a_line_a_file_below_a_head_of_names_and_units(files, capfd):
    lines = compared(capfd, files["slow"], files["fast"]).splitlines()
    assert len(lines) == 4
    assert lines[0].split()[:3] == ["file", "design", "duration"]
    assert lines[1].split() == " ".join(figure.unit for figure in FIGURES).split()
    assert lines[2].startswith(files["slow"])
    assert " 90° + 30 cm forward llsrbm-plus " in lines[2]
    assert lines[3].startswith(files["fast"])
    assert " planned " in lines[3]


def test_plans_and_simulations_are_not_ranked(files, capfd):
    out = compared(capfd, files["slow"], files["fell"])
    assert " fell " in out
    assert "*" not in out


def test_json_is_one_object_in_si_units(files, capfd):
    designs = json.loads(compared(capfd, files["slow"], files["fell"], "--json"))["designs"]
    assert [design.pop("file") for design in designs] == [files["slow"], files["fell"]]
    assert [design.pop("title") for design in designs] == [
        "90° + 30 cm forward llsrbm-plus",
        "90° + 30 cm forward llsrbm-plus, seed 7",
    ]
    assert designs[0].pop("request") == SLOW.jump.as_dict()
    assert designs[0] == asdict(figures_of_plan(SLOW))
    assert designs[1] == {"request": FELL.jump.as_dict()} | asdict(figures_of_rollout(FELL))


def test_a_file_that_is_none_is_bad_input(files, tmp_path, refused):
    assert "none.npz" in refused("compare", files["slow"], str(tmp_path / "none.npz"))
    assert refused("compare")


def test_a_file_cannot_control_the_terminal(tmp_path, refused):
    jump = replace(SLOW.jump)
    object.__setattr__(jump, "model", "\x1b[2J\nmodel")
    replace(SLOW, jump=jump).save(tmp_path / "x.npz")
    assert "\x1b" not in refused("compare", str(tmp_path / "x.npz"))
