"""Certificates of plans, foreign motions and the command that prints them."""

import json
from dataclasses import replace

import numpy as np
import pytest

import llsrbm
from llsrbm import cli
from llsrbm.certificate import CHECKS
from llsrbm.certificate.sampled_motion import SampledMotion
from llsrbm.control.controller import WholeBodyController
from llsrbm.installed import assets_directory
from llsrbm.mechanics import INSCRIBED
from llsrbm.planning.problem.placement import limits_of, task_of
from llsrbm.request.scenario import Scenario
from llsrbm.robots import load_robot
from llsrbm.sweep.jump import _forces

FIELDS = {"worst", "limit", "unit", "where", "time_s", "holds", "allowed", "why", "beyond_s"}


@pytest.fixture(scope="module")
def plan():
    return llsrbm.plan(llsrbm.Jump(robot="go2", forward=0.1), explains=False, draft=True)


def test_torques_are_those_that_the_plan_states_in_the_middle_of_intervals(plan):
    motion = SampledMotion.of(plan)
    middles = (plan.time[1:] + plan.time[:-1]) / 2
    stance = ~plan.contact[:-1].any(axis=1)
    at = np.searchsorted(motion.time, middles)
    away = np.abs(motion.torque[at] - plan.joint_torque[:-1]).max(axis=1)
    assert np.median(away[~stance]) < 0.2  # Nm of 45


def test_a_plan_is_certified_by_one_call(plan):
    certificate = llsrbm.certify(plan)
    assert [found.name for found in certificate] == [check.name for check in CHECKS]
    assert certificate["friction"].holds
    assert certificate["friction"].limit == 0.5
    assert all(set(found) == FIELDS for found in certificate.as_dict().values())
    with pytest.raises(llsrbm.InputError, match="friction"):
        certificate["frictoin"]


def slippery(folder):
    """A jump type of one's own, for a floor of ice, for legs that are not to be stretched."""
    path = folder / "ice.toml"
    text = (assets_directory() / "jump_types" / "together.toml").read_text()
    path.write_text(f"{text}\n[limits]\nfriction = 0.2\nreach_max = 0.33\n")
    return path


@pytest.mark.parametrize("robot", ["anymal", "slider"])
def test_forces_of_a_whole_body_act_where_its_feet_touch(robot):
    plan = llsrbm.load(assets_directory() / "plans" / f"{robot}.npz")
    assert llsrbm.certify(plan)["slip"].worst < 1e-3
    beside = replace(plan, contact_point=plan.contact_point + np.array([0.011, 0.0, 0.0]))
    assert not llsrbm.certify(beside)["slip"].holds


def test_equal_certificates_are_one_in_a_set(plan):
    assert len({llsrbm.certify(plan), llsrbm.certify(plan)}) == 1


def test_a_plan_is_judged_by_the_limits_that_it_was_planned_under(tmp_path, capfd):
    """Whoever says them, from the file alone, and by all who ask: the type's file is gone."""
    path, robot = slippery(tmp_path), load_robot("go2")
    jump = llsrbm.Jump(robot="go2", type=str(path), forward=0.05)
    plan = llsrbm.plan(jump, limits={"clearance": 0.05}, explains=False, draft=True)
    force = plan.contact_force[plan.contact_force[..., 2] > 1.0]
    assert (np.abs(force[:, 0]) <= 0.2 * force[:, 2] + 1e-3).all()
    saved = tmp_path / "plan.npz"
    plan.save(saved)
    again = llsrbm.load(saved)
    for known in (plan, again):
        for name, value in (("friction", 0.2), ("reach_max", 0.33), ("clearance", 0.05)):
            assert known.limits[name] == value
        assert set(known.limits) == set(limits_of(robot))
        assert llsrbm.certify(known)["friction"].limit == 0.2
        faces = WholeBodyController(robot, known, Scenario())._dynamics._faces
        assert faces[0, 2] == pytest.approx(-0.2 * INSCRIBED)
        assert _forces(known, robot)["friction_margin"] <= 0.2
    cli.main(["check", str(saved), "--json"])
    assert json.loads(capfd.readouterr().out)["certificate"]["friction"]["limit"] == 0.2
    path.write_text(path.read_text().replace("0.2", "0.4").replace("0.33", "0.34"))
    task = task_of(again, robot)
    assert (task.limits.friction, task.reach.distance[1]) == (0.2, 0.33)


def test_a_foreign_motion_has_no_forces_and_says_so(plan, tmp_path, capfd):
    path = tmp_path / "motion.csv"
    llsrbm.export(plan, path, "unitree-csv")
    status = cli.main(["check", str(path), "--robot", "go2", "--fps", "60", "--json"])
    result = json.loads(capfd.readouterr().out)
    for name in ("joint_torque", "torque_at_speed", "friction", "contact_force", "dynamics"):
        found = result["certificate"][name]
        assert (found["worst"], found["holds"]) == (None, None)
        assert "no" in found["why"]
    assert result["certificate"]["joint_position"]["worst"] > 0
    assert status == (1 if result["holds"] is False else 0)
    assert result["holds"] is not True


@pytest.mark.parametrize("given", [np.zeros((9, 19)), "jump.csv", None, {"qpos": []}])
def test_what_is_no_motion_is_refused(given):
    with pytest.raises(
        llsrbm.InputError, match=r"expected a Plan, .*[( ]`llsrbm\.load_motion` opens"
    ):
        llsrbm.certify(given)


def test_the_table_and_the_exit_status(plan, tmp_path, capfd):
    path = tmp_path / "plan.npz"
    plan.save(path)
    certificate = llsrbm.certify(plan)
    assert cli.main(["check", str(path)]) == (1 if certificate.holds is False else 0)
    out = capfd.readouterr().out.splitlines()
    assert out[len(CHECKS) + 1].startswith("The certificate")
    assert out[len(CHECKS) + 2].startswith("Peak power: ")
    assert out[-1].startswith("Drives of go2: ")
    assert out[0].split() == ["check", "worst", "allowed", "limit", "where", "time"]


def test_what_is_no_motion_is_bad_input(tmp_path, refused):
    path = tmp_path / "plan.npz"
    path.write_bytes(b"nothing")
    assert refused("check", str(path))
