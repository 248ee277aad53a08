"""Our own files in full, other tools' for looking; figures of both beside each other."""

import json
import math

import numpy as np
import pytest

from llsrbm import cli
from llsrbm.analysis.figures import figures_of_motion, figures_of_plan
from llsrbm.formats import export, load_any
from tests.llsrbm.formats.jumps import planned, simulated


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("files")
    planned("anymal").save(made / "plan.npz")
    simulated("anymal").save(made / "run.npz")
    export(planned("anymal"), made / "unitree.csv", format="unitree-csv", fps=100)
    export(planned("anymal"), made / "tracking.npz", format="motion-npz", fps=100)
    (made / "cut.npz").write_bytes((made / "plan.npz").read_bytes()[:1000])
    return made


@pytest.mark.parametrize("name", ["unitree.csv", "tracking.npz"])
def test_another_tools_motion_has_the_figures_of_the_plan_it_was_made_from(folder, name):
    plan, motion = planned("anymal"), load_any(folder / name)
    expected, figures = figures_of_plan(plan), figures_of_motion(motion)
    assert figures.status == "motion"
    assert not figures.valid
    assert figures.duration_s == pytest.approx(plan.duration, abs=0.011)
    assert figures.flight_time_s == pytest.approx(expected.flight_time_s, abs=0.08)
    assert figures.apex == pytest.approx(expected.apex, abs=0.003)
    assert figures.final_yaw == pytest.approx(plan.jump.twist, abs=math.radians(0.5))
    assert figures.peak_yaw_rate == pytest.approx(expected.peak_yaw_rate, rel=0.05)
    assert figures.smallest_Izz == pytest.approx(expected.smallest_Izz, rel=0.05)
    assert figures.peak_force is None
    assert figures.solve_time_s is None


def test_one_that_never_leaves_the_ground_has_no_flight(folder):
    motion = load_any(folder / "tracking.npz")
    standing = np.ones_like(motion.contact)
    object.__setattr__(motion, "contact", standing)
    figures = figures_of_motion(motion)
    assert (figures.flight_time_s, figures.feet_radius, figures.smallest_Izz) == (None, None, None)


def test_they_are_compared_on_the_command_line(folder, capfd):
    files = [str(folder / name) for name in ("plan.npz", "tracking.npz")]
    assert cli.main(["compare", *files, "--robot", "anymal", "--fps", "100"]) == 0
    lines = capfd.readouterr().out.splitlines()
    assert " planned " in lines[2]
    assert " motion-npz " in lines[3]
    assert " motion " in lines[3]
    assert cli.main(["compare", *files, "--json"]) == 0
    first, second = json.loads(capfd.readouterr().out)["designs"]
    assert (first["title"].endswith("llsrbm-plus"), second["title"]) == (True, "motion-npz")
    assert second["request"] is None
    assert second["solve_time_s"] is None
