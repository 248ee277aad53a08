import json
import math

import pytest

from llsrbm.cli import main
from llsrbm.commands.options import requested_tuning
from llsrbm.errors import InputError
from llsrbm.planning.problem.costs import COSTS
from llsrbm.planning.problem.placement import limits_of
from llsrbm.request.tuning import Tuning
from llsrbm.robots import load_robot


def test_the_table_has_every_weight_and_limit_of_the_robot(capsys):
    assert main(["tuning", "--robot", "slider"]) == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    values = {(kind, name): float(value) for kind, name, value, *_ in rows[1:]}
    slider = load_robot("slider")
    limits = limits_of(slider)
    assert [name for _, name in values] == [
        *(c.name for c in COSTS if c.concerns(slider)),
        *limits,
    ]
    assert values["weight", "symmetry"] == slider.file.planning["symmetry"]
    assert values["weight", "tilt"] == 50.0  # of all robots
    assert values["limit", "foot_yaw_max"] == pytest.approx(63.03, abs=0.01)
    assert values["limit", "foot_speed"] == slider.file.limits.foot_speed
    assert values["limit", "torque_share"] == 0.85


def test_options_override_a_design():
    design = Tuning(weights={"time": 5.0}, limits={"friction": 0.4, "clearance": 0.1})
    tuning = requested_tuning(design, ["tilt=3"], ["friction=0.6", "foot_yaw_max=30"])
    assert tuning.weights == {"time": 5.0, "tilt": 3.0}
    expected = {"friction": 0.6, "clearance": 0.1, "foot_yaw_max": math.radians(30)}
    assert tuning.limits == pytest.approx(expected)


@pytest.mark.parametrize("given", ["friction", "friction=", "=", "friction=low", ""])
def test_what_is_no_assignment(given):
    with pytest.raises(InputError, match="expected NAME=VALUE with a number"):
        requested_tuning(Tuning(), None, [given])


def test_a_plan_under_another_limit(capfd, tmp_path):
    out = tmp_path / "plan.npz"
    arguments = [
        "plan",
        "--draft",
        "--model",
        "srbm",
        "--limit",
        "flight_min=0.4",
        "--weight",
        "time=10",
    ]
    assert main([*arguments, "--json", "--out", str(out)]) == 0
    from llsrbm.motion.trajectory import load

    plan = load(out)
    assert plan.tuning == Tuning(weights={"time": 10.0}, limits={"flight_min": 0.4})
    assert json.loads(capfd.readouterr().out)["phase_durations_s"][1] >= 0.399


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--limit", "fricton=1"], "unknown limit 'fricton'; the limits of anymal are friction"),
        (["--limit", "friction=9"], "limit friction: 9 is out of range"),
        (["--weight", "tme=1"], "unknown weight 'tme'"),
    ],
)
def test_bad_input_is_one_line(refused, options, said):
    assert said in refused("plan", *options)
