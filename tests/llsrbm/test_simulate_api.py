"""`llsrbm.simulate`: what it accepts, and what it hands on to the simulator."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import llsrbm
from llsrbm.errors import InputError
from llsrbm.motion.solve_report import Violation
from llsrbm.request.scenario import Scenario
from llsrbm.robots import load_robot
from llsrbm.simulation import simulate as simulator
from tests.llsrbm.synthetic import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout


@pytest.fixture(scope="module")
def plan():
    """Of the ANYmal that is here, as far as a plan says so."""
    robot = load_robot("anymal")
    plan = synthetic_plan(twist=0.5)
    order = [robot.joint_names.index(name) for leg in robot.legs for name in leg.joints]
    return replace(
        plan,
        robot_parameters=robot.parameters(),
        joint_names=robot.joint_names,
        joint_position=plan.joint_position[:, order],
    )


@pytest.fixture
def calls(monkeypatch):
    """What reached the simulator, which answers with a rollout made by hand."""
    calls = []

    def simulate(plan, robot, scenario, *, cancelled, progress, so_far):
        calls.append(SimpleNamespace(**locals()))
        return replace(synthetic_rollout(plan), scenario=scenario)

    monkeypatch.setattr(simulator, "simulate", simulate)
    return calls


def refused(*arguments, **options):
    with pytest.raises(InputError) as caught:
        llsrbm.simulate(*arguments, **options)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_what_is_not_said_is_nominal(plan, calls):
    rollout = llsrbm.simulate(plan)
    assert isinstance(rollout, llsrbm.Rollout)
    assert rollout.scenario == Scenario()
    assert calls[0].plan is plan
    assert calls[0].robot is load_robot("anymal")


def test_everything_reaches_the_simulator(plan, calls):
    def cancelled():
        return False

    llsrbm.simulate(
        plan, board=0.025, half_board=True, seed=np.int64(1004), noise=0.5, detector="norm",
        landing="planned", solver="quadprog", trunk_mass=-0.12, cancelled=cancelled, progress=print,
        so_far=repr,
    )  # fmt: skip
    scenario = Scenario(0.025, True, 1004, 0.5, "norm", "planned", "quadprog", -0.12)
    assert calls[0].scenario == scenario
    assert type(calls[0].scenario.seed) is int
    assert calls[0].cancelled is cancelled
    assert calls[0].progress is print
    assert calls[0].so_far is repr


@pytest.mark.parametrize(
    ("given", "expected"), [({"seed": 4}, (4, 1.0)), ({"noise": 0.0}, (0, 0.0))]
)
def test_a_seed_or_a_noise_alone_disturbs(plan, calls, given, expected):
    llsrbm.simulate(plan, **given)
    assert (calls[0].scenario.seed, calls[0].scenario.noise) == expected


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"board": -0.01}, "board: expected 0 to 1 m, got -0.01"),
        ({"sead": 3}, 'unknown field "sead"; did you mean "seed"? valid: board, half_board, seed'),
        ({"detector": "nosuch"}, "residual, norm"),
        ({"landing": "nosuch"}, "auto, scaled, planned, tracking"),
        ({"solver": "nosuch"}, "valid: quadprog"),
    ],
)
def test_a_scenario_that_makes_no_sense(plan, calls, options, said):
    assert said in refused(plan, **options)
    assert not calls


def test_a_scenario_or_its_fields(plan, calls):
    assert "its fields, got seed beside a Scenario" in refused(plan, Scenario(), seed=3)
    assert "expected a Scenario, got a dict" in refused(plan, {"seed": 3})
    assert not calls


def test_what_is_no_plan(calls):
    assert "got a Jump; plan it first: llsrbm.plan(jump)" in refused(llsrbm.Jump())
    assert "expected a plan to simulate, got a Rollout" in refused(synthetic_rollout())
    assert "got a str" in refused("plan.npz")
    assert not calls


def test_a_plan_that_did_not_converge_names_its_worst_violation(plan, calls):
    plan = replace(
        plan,
        report=replace(plan.report, status="not-converged"),
        violations={
            "reach": Violation(1e-9, "m", "take-off", 0.0),
            "friction": Violation(3.0, "N", "landing", 1.1),
        },
    )
    assert "friction is violated by 3 N in landing at 1.10 s" in refused(plan)
    assert not calls


class TestAnotherRobot:
    @pytest.mark.parametrize(
        ("name", "value", "said"),
        [
            ("name", "spot", "its name is spot"),
            ("mass", 99.0, "its mass is 99.0"),
            ("legs", {"LEFT": {"foot": "L", "hip": "H"}}, "its legs is LEFT"),
            ("joint_names", ["a", "b"], "its joint_names is a, b"),
        ],
    )
    def test_by_its_parameters(self, plan, calls, name, value, said):
        other = replace(plan, robot_parameters={**plan.robot_parameters, name: value})
        text = refused(other)
        assert text.startswith("the plan is of another robot")
        assert said in text
        assert "plan the jump again" in text
        assert not calls

    def test_with_arrays_of_another_robot(self, plan, calls):
        names = tuple(f"joint{i}" for i in range(12))
        assert "of another robot" in refused(replace(plan, joint_names=names))
        assert "it has 2 feet" in refused(replace(plan, foot_position=plan.foot_position[:, :2]))

    def test_that_has_other_gains_only_is_the_same(self, plan, calls, tmp_path):
        path = tmp_path / "mine.toml"
        for rate in (400.0, 500.0):  # edited between two simulations of one plan
            text = load_robot("anymal").path.read_text()
            path.write_text(f"{text}\n[control]\nrate = {rate}\n")
            llsrbm.simulate(replace(plan, jump=llsrbm.Jump(robot=str(path))))
            assert calls[-1].robot.file.control.rate == rate

    def test_without_a_force_phase_follows_no_forces(self, plan, calls, tmp_path):
        path = tmp_path / "mine.toml"
        text = load_robot("anymal").path.read_text()
        path.write_text(f"{text}\n[control]\nforce_phase = 0.0\n")
        plan = replace(plan, jump=llsrbm.Jump(robot=str(path)))
        for strategy in ("scaled", "planned"):
            said = refused(plan, landing=strategy)
            assert f'"{strategy}" follows forces' in said
        assert not calls
        llsrbm.simulate(plan)
        llsrbm.simulate(plan, landing="tracking")
        assert [call.scenario.landing for call in calls] == ["auto", "tracking"]

    def test_that_is_not_here(self, plan, calls):
        assert 'no robot "nosuch"' in refused(replace(plan, jump=llsrbm.Jump(robot="nosuch")))

    def test_mass_may_differ_by_rounding(self, plan, calls):
        mass = plan.robot_parameters["mass"] * (1 + 1e-9)
        llsrbm.simulate(replace(plan, robot_parameters={**plan.robot_parameters, "mass": mass}))
        assert calls
