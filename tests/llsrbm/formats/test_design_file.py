"""What a plan or a rollout was asked for, read back as a design."""

from dataclasses import replace

import pytest

from llsrbm.formats import export, file_name
from llsrbm.request.design import Design, load_design
from llsrbm.request.scenario import Push, Scenario
from llsrbm.request.tuning import Tuning
from tests.llsrbm.synthetic import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout

TUNING = Tuning(weights={"time": 3.0}, limits={"friction": 0.4})
SCENARIO = Scenario(
    board=0.02,
    half_board=True,
    seed=7,
    detector="norm",
    trunk_mass=-0.1,
    pushes=(Push(0.4, (0, 12, 0), (0, 0, 1)),),
    replan=True,
)
PLAN = replace(synthetic_plan(), tuning=TUNING)
ROLLOUT = replace(synthetic_rollout(PLAN), scenario=SCENARIO)


@pytest.mark.parametrize(
    ("trajectory", "design"),
    [(PLAN, Design(PLAN.jump, TUNING)), (ROLLOUT, Design(PLAN.jump, TUNING, SCENARIO))],
    ids=["plan", "rollout"],
)
def test_it_says_what_was_asked_for(trajectory, design, tmp_path):
    path = tmp_path / file_name(trajectory, ["design"])
    assert path.name.endswith(".jump.json")
    export(trajectory, path, format="design")
    assert load_design(path) == design
