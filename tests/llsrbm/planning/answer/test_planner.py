"""Plans of every model and jump type, and the planners that make them."""

from itertools import pairwise

import numpy as np
import pytest

from llsrbm import models
from llsrbm.errors import InputError, NotConverged
from llsrbm.planning.answer.planner import Planner, planner_for, planner_of
from llsrbm.planning.problem.constraints import AGREED
from llsrbm.planning.problem.constraints.drives import (
    SPEED_ALLOWANCE,
    TORQUE_ALLOWANCE,
)
from llsrbm.planning.problem.violations import TOLERANCE
from llsrbm.planning.solve import formulation
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.llsrbm.kinematics import foot_positions
from tests.llsrbm.planning.solved import REQUESTS, TYPES, solved

every_model = pytest.mark.parametrize("model", models.MODELS)
ROBOT = load_robot("anymal")


@every_model
def test_reported_as_the_contract_says(model):
    plan = solved(model, "all").plan
    report = plan.report
    assert plan.solved
    assert (report.status, report.solver, report.attempts) == ("solved", "fatrop", 1)
    assert 0 < report.iterations < 100
    assert 0 < report.solve_time_s < report.total_time_s
    assert plan.jump == Jump(model=model, **REQUESTS["all"])
    assert plan.robot_parameters["name"] == "anymal"
    assert max(v.amount for v in plan.violations.values()) <= TOLERANCE


@every_model
def test_arrays_of_the_contract(model):
    s = solved(model, "all")
    plan, legs = s.plan, 4
    assert (np.diff(plan.time) > 0).all()
    assert (np.diff(plan.phase) >= 0).all()
    assert plan.phase_names == ("take-off", "flight", "landing")
    assert set(plan.phase) == {0, 1, 2}
    flight = plan.phase == 1
    np.testing.assert_array_equal(plan.contact, np.repeat(~flight[:, None], legs, axis=1))
    assert not plan.contact_force[flight].any()
    np.testing.assert_allclose(np.linalg.norm(plan.base_quat, axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(plan.linear_momentum, plan.com_velocity * ROBOT.mass)
    assert plan.base_mass + plan.leg_mass.sum() == pytest.approx(ROBOT.mass)
    # In flight only gravity acts.
    assert np.ptp(plan.angular_momentum[flight], axis=0).max() < 1e-6
    fall = np.diff(plan.com_velocity[flight], axis=0) / np.diff(plan.time[flight])[:, None]
    np.testing.assert_allclose(fall, np.tile([0, 0, -9.81], (len(fall), 1)), atol=1e-8)


@every_model
def test_ends_where_it_was_asked_to(model):
    s = solved(model, "all")
    plan = s.plan
    np.testing.assert_allclose(plan.com[-1], s.task.goal_position, atol=1e-5)
    np.testing.assert_allclose(plan.base_quat[-1], s.task.goal_quat, atol=1e-5)
    np.testing.assert_allclose(plan.foot_position[-1], s.task.places[-1].feet, atol=1e-6)
    np.testing.assert_allclose(plan.foot_position[0], s.task.places[0].feet)
    for name in ("com_velocity", "angular_velocity", "angular_momentum"):
        assert np.abs(getattr(plan, name)[[0, -1]]).max() < 1e-5


@every_model
def test_the_posture_puts_the_feet_and_the_com_where_the_plan_has_them(model):
    """By Pinocchio's forward kinematics of a model of its own."""
    import pinocchio as pin

    plan = solved(model, "all").plan
    feet = foot_positions(ROBOT, plan.base_position, plan.base_quat, plan.joint_position)
    assert np.linalg.norm(feet - plan.foot_position, axis=-1).max() < 5e-3
    data = ROBOT.model.createData()
    postures = zip(plan.base_position, plan.base_quat, plan.joint_position, strict=True)
    for k, (p, q, angles) in enumerate(postures):
        com = pin.centerOfMass(ROBOT.model, data, np.concatenate([p, np.roll(q, -1), angles]))
        np.testing.assert_allclose(com, plan.com[k], atol=1e-6)


@pytest.mark.parametrize("name", TYPES)
def test_what_a_plan_of_any_type_holds(name):
    s = solved("llsrbm-plus", name)
    plan, schedule = s.plan, s.task.schedule
    assert plan.solved
    assert plan.report.attempts == 1
    assert plan.schedule == schedule
    np.testing.assert_array_equal(plan.contact, schedule.stands[plan.phase])
    assert len(plan.time) == s.planner.layout.knots
    # Feet push only where they stand, and do not move there.
    assert not plan.contact_force[~plan.contact].any()
    still = plan.contact[:-1] & plan.contact[1:]
    step = np.linalg.norm(np.diff(plan.foot_position, axis=0), axis=-1)
    assert step[still].max() < 1e-9
    np.testing.assert_allclose(plan.foot_position[-1], s.task.places[-1].feet, atol=1e-6)
    np.testing.assert_allclose(plan.com[-1], s.task.goal_position, atol=1e-5)
    flying = ~plan.contact.any(axis=1)
    for flight in s.knots.flights:
        assert flying[flight].all()
        inside = slice(flight.start, flight.stop + 1)
        assert np.ptp(plan.angular_momentum[inside], axis=0).max() < 1e-6
    for p, (start, end) in enumerate(pairwise(plan.phase_start)):
        low, high = s.task.times(p)
        assert low - 1e-3 <= end - start <= high + 1e-3


def test_a_run_up_begins_and_ends_with_its_speed():
    plan = solved("llsrbm-plus", "run-up").plan
    np.testing.assert_allclose(plan.com_velocity[0], [0.5, 0, 0])
    np.testing.assert_allclose(plan.com_velocity[-1], [0.2, 0, 0], atol=1e-5)
    # The feet stand, so the joints follow the body.
    assert np.abs(plan.joint_velocity[[0, -1]]).max(axis=1).min() > 0.2


def test_the_papers_model_draws_the_feet_in_and_turns_faster():
    """90 degrees: a changing inertia is used, a constant one is not; 5 %, as rotors take effort."""

    def radius(plan):
        flying = plan.phase == 1
        arms = plan.foot_position[flying][..., :2] - plan.com[flying][:, None, :2]
        return np.linalg.norm(arms, axis=-1).mean(axis=1).min()

    def yaw_rate(plan):
        return np.abs(plan.angular_velocity[:, 2]).max()

    rigid, lumped = (solved(model, "twist").plan for model in ("srbm", "llsrbm"))
    assert radius(lumped) < radius(rigid) - 0.015
    assert yaw_rate(lumped) > 1.04 * yaw_rate(rigid)
    flying = lumped.phase == 1
    Izz = lumped.inertia[flying, 2, 2]
    assert Izz.min() < 0.95 * ROBOT.inertia[2, 2]
    assert lumped.report.cost < rigid.report.cost


def test_the_same_request_gives_the_same_plan():
    again = Planner(ROBOT, "srbm").plan(Jump(model="srbm", **REQUESTS["all"]))
    before = solved("srbm", "all").plan
    np.testing.assert_array_equal(again.joint_position, before.joint_position)
    assert again.report.iterations == before.report.iterations


@pytest.mark.nightly
def test_ipopt_agrees():
    jump = Jump(model="srbm", **REQUESTS["twist"])
    other = planner_for("anymal", "srbm", "ipopt").plan(jump)
    plan = solved("srbm", "twist").plan
    assert other.report.solver == "ipopt"
    assert other.report.cost == pytest.approx(plan.report.cost, rel=5e-3)
    np.testing.assert_allclose(other.com, plan.com, atol=0.01)


@pytest.mark.nightly
def test_where_the_whole_body_alone_objects_the_rows_of_the_drives_follow_it(monkeypatch):
    jump = Jump(twist=-1.9, forward=0.264, lateral=0.265, height=0.008)
    planner, robot = planner_of(jump), load_robot("anymal")
    plan = planner.plan(jump, patient=False)
    assert plan.report.attempts == 1
    task, loads = planner.last.task, planner.last_knots().loads
    assert {c.name for c in AGREED} == set(task.agreed_bounds)
    share, limit = robot.file.limits.torque_share, robot.torque_limit
    assert (np.abs(loads.joint_torque) <= (share + TORQUE_ALLOWANCE) * limit + TOLERANCE).all()
    top = robot.file.limits.speed_share + SPEED_ALLOWANCE
    assert (np.abs(loads.joint_velocity) <= top * robot.speed_limit + TOLERANCE).all()
    # Joints are fastest at lift-off and touchdown.
    assert (np.abs(plan.joint_velocity) <= 1.01 * robot.speed_limit + TOLERANCE).all()
    monkeypatch.setattr(formulation, "MAX_SHIFTS", 0)
    with pytest.raises(NotConverged) as caught:
        planner.plan(jump, patient=False)
    broken = {name for name, v in caught.value.plan.violations.items() if v.amount > TOLERANCE}
    assert broken <= set(task.agreed_bounds)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("srmb",), 'no model "srmb"; did you mean "srbm"? valid: srbm, llsrbm, llsrbm-plus'),
        (("srbm", "snopt"), 'no solver "snopt"; did you mean "ipopt"? valid: fatrop, ipopt'),
        (("srbm", "fatrop", 6), "intervals: 6 given; expected 9 to 300"),
        (("srbm", "fatrop", 301), "intervals: 301 given; expected 9 to 300"),
    ],
)
def test_what_it_cannot_be_made_of(arguments, message):
    with pytest.raises(InputError) as caught:
        planner_for("anymal", *arguments)
    assert str(caught.value) == message


def test_a_changed_robot_file_gets_another_planner(tmp_path):
    path = tmp_path / "mine.toml"
    text = ROBOT.path.read_text()
    path.write_text(text)
    first = planner_for(str(path), "srbm")
    assert planner_for(str(path), "srbm") is first
    path.write_text(text + "\n[control]\nfriction = 0.45\n")
    assert planner_for(str(path), "srbm").robot.file.control.friction == 0.45
