from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import llsrbm
from llsrbm import certified_plan
from llsrbm.certificate import Certificate, Finding
from llsrbm.installed import package_version
from llsrbm.motion.solve_report import Refinement
from llsrbm.robots import load_robot
from llsrbm.sweep import jump, rows
from llsrbm.sweep.points import Points
from tests.llsrbm.sweep.specs import parse_spec

SPEC = """
title = "real plans"
draft = true
robots = ["anymal"]
models = ["srbm"]
patient = false
trajectories = true
[axes]
lateral = [0.2]
height = [0.1, 9.0]
[limits]
torque_share = [0.3, 0.85]
[simulate]
seeds = 2
"""


def computed(spec, numbers):
    points = Points(spec)
    made = [row for number in numbers for row in jump.rows_of(spec, points[number])]
    return rows.table_of(made, rows.schema(spec))


@pytest.fixture(scope="module")
def spec():
    return parse_spec(SPEC, "x")


@pytest.fixture(scope="module")
def forth(spec):
    return computed(spec, range(4))


def test_a_row_says_what_became_of_its_jump(spec, forth):
    found = forth.to_pylist()
    assert [row["index"] for row in found] == [*range(8)]
    by_request = {(r["limit_torque_share"], round(r["height"], 1)): r for r in found}
    planned = by_request[0.85, 0.1]
    assert planned["status"] == "planned"
    assert planned["message"] is None
    parts = planned["takeoff_s"] + planned["flight_s"] + planned["landing_s"]
    assert parts == pytest.approx(planned["duration_s"])
    assert planned["landed"] is True
    assert 0 < planned["torque_share"] < 1.1
    assert planned["torque_share"] == max(dict(planned["joint_torque_ratio"]).values())
    assert 0 <= planned["friction_margin"] < 0.5
    refused = by_request[0.85, 9.0]
    assert refused["status"] == "refused"
    assert "height 9 m is out of range" in refused["message"]
    assert refused["duration_s"] is refused["landed"] is None
    weak = by_request[0.3, 0.1]
    assert weak["status"] == "not planned"
    assert weak["stopped_by"] == weak["constraint"]
    assert weak["constraint"] in dict(weak["violations"])
    assert weak["landed"] is None
    assert {row["version"] for row in found} == {package_version()}
    assert {row["robot_hash"] for row in found} == {rows.robot_hash("anymal")}


def test_a_row_is_what_the_library_makes_of_the_same_jump(forth):
    row = forth.to_pylist()[4]
    request = llsrbm.Jump("anymal", "srbm", lateral=0.2, height=0.1)
    plan = llsrbm.plan(request, limits={"torque_share": 0.85}, draft=True)
    assert row["cost"] == plan.report.cost
    assert row["duration_s"] == plan.duration
    rollout = llsrbm.simulate(plan, seed=row["seed"])
    assert row["strict"] == rollout.outcome.strict
    assert row["foot_error"] == rollout.outcome.foot_error
    force = np.reshape(row["motion_contact_force"], plan.contact_force.shape)
    np.testing.assert_array_equal(force, plan.contact_force)
    assert row["motion_joint_names"] == [*plan.joint_names]
    # In the first row of each planned jump, and nowhere else.
    assert forth["motion_com"].is_valid().to_pylist() == [k == 4 for k in range(8)]


def test_what_goes_wrong_is_a_row(monkeypatch, spec):
    def breaks(point):
        raise ZeroDivisionError("nobody thought of that")

    monkeypatch.setattr(jump, "_planner", breaks)
    found = computed(spec, [0]).to_pylist()
    assert [row["status"] for row in found] == ["failed", "failed"]
    assert found[0]["message"] == "nobody thought of that"


def test_drives_are_those_asked_for(spec):
    asked = parse_spec(SPEC + "[drives]\ntorque = [1.25]\nspeed = [0.5]\n", "x")
    robot, own = jump._robot(Points(asked)[0]), load_robot("anymal")
    np.testing.assert_allclose(robot.torque_limit, 1.25 * own.torque_limit)
    np.testing.assert_allclose(robot.speed_limit, 0.5 * own.speed_limit)
    assert jump._robot(Points(asked)[1]) is robot
    assert jump._robot(Points(spec)[0]) is own


def test_plans_without_a_certificate_that_holds_are_rows_alone(monkeypatch):
    demanding = parse_spec(SPEC.replace("draft = true\n", ""), "x")
    seen = []

    def certified(plan, robot):
        seen.append(robot)
        # The first jump's fails, also on a finer grid.
        slip = Finding("slip", 0.02, 0.01, "m", "LF", 0.4, len(seen) > 2, 0.01)
        return replace(plan, certificate=Certificate((slip,)).as_dict())

    settled = SimpleNamespace(solver=SimpleNamespace(settle=lambda: None))
    effort = Refinement("solved", 9, 0.1, 0.1, 0.0, 1.0)
    monkeypatch.setattr(certified_plan, "refiner_of", lambda *_: settled)
    monkeypatch.setattr(
        certified_plan, "refined", lambda plan, *_, **__: replace(plan, refinement=effort)
    )
    monkeypatch.setattr(certified_plan, "certified", certified)
    points = Points(demanding)
    refused = jump.rows_of(demanding, points[2])
    assert [row["status"] for row in refused] == [rows.NOT_CERTIFIED] * 2
    assert refused[0]["certified"] is False
    assert refused[0]["uncertified"] == ["slip"]
    assert refused[0]["message"] == "its certificate does not hold: slip"
    assert "landed" not in refused[0]
    assert not any(name.startswith("motion_") for name in refused[0])
    kept = jump.rows_of(demanding, points[2])
    assert [row["status"] for row in kept] == [rows.PLANNED] * 2
    assert kept[0]["certified"] is True
    assert "landed" in kept[0]
    # As all columns, these are the table's; of drafts they are null.
    table = rows.table_of([*refused, *kept], rows.schema(demanding))
    assert table["certified"].to_pylist() == [False, False, True, True]
    assert all(robot.name == "anymal" for robot in seen)
    effort = replace(effort, status="not-converged")
    (none, _) = jump.rows_of(demanding, points[2])
    assert (none["status"], none["certified"]) == (rows.NOT_CERTIFIED, False)
    assert none["message"] == "the whole body's plan was not found"


def test_a_plan_of_the_whole_body_is_the_one_that_the_library_makes(monkeypatch):
    monkeypatch.setattr(jump, "_planner", lambda _: pytest.fail("a draft was begun"))
    spec = parse_spec(
        'title = "whole bodies"\nrobots = ["go2"]\n[axes]\ntwist = [0.6]\nforward = [0.1]', "x"
    )
    point = Points(spec)[0]
    plan = jump.plan_of(spec, point)
    own = llsrbm.plan(point.jump)
    assert plan.certified
    assert plan.com == pytest.approx(own.com, abs=1e-9)
    assert plan.joint_torque == pytest.approx(own.joint_torque, abs=1e-9)
