from dataclasses import replace

import numpy as np
import pytest

import llsrbm
from llsrbm import models
from llsrbm.errors import Cancelled, InputError, NotConverged
from llsrbm.joint_margins import joint_margins
from llsrbm.jump import Jump
from llsrbm.planning import solvers
from llsrbm.planning.planner import INTERVALS, PATIENT_FLIGHT, Planner, planner_for
from llsrbm.planning.residuals import TOLERANCE, excess
from llsrbm.robots import load_robot
from llsrbm.trajectory.plan import Phase
from tests.llsrbm.kinematics import foot_positions
from tests.llsrbm.planning.solved import REQUESTS, solved

every_plan = pytest.mark.parametrize("request_name", REQUESTS)
every_model = pytest.mark.parametrize("model", models.names())
ROBOT = load_robot("anymal")


@pytest.fixture
def planner():
    """One of its own, to be tampered with; its solver comes from the cache."""
    return Planner(ROBOT, "srbm")


# ---- what a plan holds


@every_plan
@every_model
def test_reported_as_the_contract_says(model, request_name):
    plan = solved(model, request_name).plan
    report = plan.report
    assert plan.solved
    assert (report.status, report.solver, report.attempts) == ("solved", "fatrop", 1)
    assert 0 < report.iterations < 100
    assert 0 < report.solve_time_s < report.total_time_s
    assert plan.jump == Jump(model=model, **REQUESTS[request_name])
    assert plan.robot_parameters["name"] == "anymal"
    assert max(v.amount for v in plan.violations.values()) <= TOLERANCE


@every_plan
@every_model
def test_arrays_of_the_contract(model, request_name):
    s = solved(model, request_name)
    plan, knots, legs = s.plan, INTERVALS + 1, 4
    shapes = {
        "time": (knots,),
        "phase": (knots,),
        "com": (knots, 3),
        "com_velocity": (knots, 3),
        "base_quat": (knots, 4),
        "base_position": (knots, 3),
        "angular_velocity": (knots, 3),
        "linear_momentum": (knots, 3),
        "angular_momentum": (knots, 3),
        "inertia": (knots, 3, 3),
        "foot_position": (knots, legs, 3),
        "foot_quat": (knots, legs, 4),
        "contact_point": (knots, legs, 3),
        "contact_force": (knots, legs, 3),
        "leg_mass": (legs,),
        "leg_com": (knots, legs, 3),
        "joint_position": (knots, 12),
        "foot_in_hip": (knots, legs, 3),
    }
    for name, shape in shapes.items():
        array = getattr(plan, name)
        assert array.shape == shape, name
        assert np.isfinite(array).all(), name
    assert (np.diff(plan.time) > 0).all()
    assert (np.diff(plan.phase) >= 0).all()
    assert set(plan.phase) == set(Phase)
    flight = plan.phase == Phase.FLIGHT
    assert not plan.contact_force[flight].any()
    np.testing.assert_allclose(np.linalg.norm(plan.base_quat, axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(plan.linear_momentum, plan.com_velocity * ROBOT.mass)
    assert plan.base_mass + plan.leg_mass.sum() == pytest.approx(ROBOT.mass)
    # In flight only gravity acts.
    assert np.ptp(plan.angular_momentum[flight], axis=0).max() < 1e-6
    fall = np.diff(plan.com_velocity[flight], axis=0) / np.diff(plan.time[flight])[:, None]
    np.testing.assert_allclose(fall, np.tile([0, 0, -9.81], (len(fall), 1)), atol=1e-8)


@every_plan
@every_model
def test_ends_where_it_was_asked_to(model, request_name):
    s = solved(model, request_name)
    plan = s.plan
    np.testing.assert_allclose(plan.com[-1], s.task.goal_position, atol=1e-5)
    np.testing.assert_allclose(plan.base_quat[-1], s.task.goal_quat, atol=1e-5)
    np.testing.assert_allclose(plan.foot_position[-1], s.task.goal_feet, atol=1e-6)
    np.testing.assert_allclose(plan.foot_position[0], s.task.start_feet)
    for name in ("com_velocity", "angular_velocity", "angular_momentum"):
        assert np.abs(getattr(plan, name)[[0, -1]]).max() < 1e-5


@every_plan
@every_model
def test_the_posture_puts_the_feet_and_the_com_where_the_plan_has_them(model, request_name):
    """By Pinocchio's forward kinematics of a model of its own."""
    import pinocchio as pin

    plan = solved(model, request_name).plan
    feet = foot_positions(ROBOT, plan.base_position, plan.base_quat, plan.joint_position)
    assert np.linalg.norm(feet - plan.foot_position, axis=-1).max() < 5e-3
    data = ROBOT.model.createData()
    postures = zip(plan.base_position, plan.base_quat, plan.joint_position, strict=True)
    for k, (p, q, angles) in enumerate(postures):
        com = pin.centerOfMass(ROBOT.model, data, np.concatenate([p, np.roll(q, -1), angles]))
        np.testing.assert_allclose(com, plan.com[k], atol=1e-6)


@pytest.mark.parametrize("request_name", ["twist", "forward"])
@every_model
def test_the_joints_keep_their_speed(model, request_name):
    margins = joint_margins(solved(model, request_name).plan, ROBOT)
    assert margins.peak_speed <= 15.0


# ---- the paper's result


def test_the_papers_model_draws_the_feet_in_and_turns_faster():
    """90 degrees: a changing inertia is used, a constant one is not."""

    def radius(plan):
        flying = plan.phase == Phase.FLIGHT
        arms = plan.foot_position[flying][..., :2] - plan.com[flying][:, None, :2]
        return np.linalg.norm(arms, axis=-1).mean(axis=1).min()

    def yaw_rate(plan):
        return np.abs(plan.angular_velocity[:, 2]).max()

    rigid, lumped = (solved(model, "twist").plan for model in ("srbm", "llsrbm"))
    assert radius(lumped) < radius(rigid) - 0.02
    assert yaw_rate(lumped) > 1.1 * yaw_rate(rigid)
    flying = lumped.phase == Phase.FLIGHT
    Izz = lumped.inertia[flying, 2, 2]
    assert Izz.min() < 0.95 * ROBOT.inertia[2, 2]
    assert lumped.report.cost < rigid.report.cost


def test_left_and_right_are_mirror_images():
    planner = planner_for("anymal", "srbm")
    left, right = (planner.plan(Jump(model="srbm", twist=t)) for t in (0.9, -0.9))
    assert left.report.cost == pytest.approx(right.report.cost, rel=2e-3)
    np.testing.assert_allclose(left.com[:, 2], right.com[:, 2], atol=5e-3)


# ---- how it gets there


def test_a_warm_start_finds_the_same_optimum_sooner(planner):
    planner.plan(Jump(model="srbm", twist=1.2, forward=0.1))
    jump = Jump(model="srbm", twist=1.25, forward=0.12)
    warm = planner.plan(jump, warm=True)
    cold = planner.plan(jump)
    assert warm.report.attempts == cold.report.attempts == 1
    assert warm.report.iterations < cold.report.iterations
    assert warm.report.cost == pytest.approx(cold.report.cost, rel=2e-3)
    np.testing.assert_allclose(warm.com, cold.com, atol=5e-3)


def test_warm_without_a_plan_before_is_cold(planner):
    jump = Jump(model="srbm", twist=0.5)
    warm, cold = planner.plan(jump, warm=True), planner.plan(jump)
    np.testing.assert_array_equal(warm.com, cold.com)


def test_the_same_request_gives_the_same_plan(planner):
    again = planner.plan(Jump(model="srbm", **REQUESTS["all"]))
    before = solved("srbm", "all").plan
    np.testing.assert_array_equal(again.joint_position, before.joint_position)
    assert again.report.iterations == before.report.iterations


def test_ipopt_agrees():
    jump = Jump(model="srbm", **REQUESTS["twist"])
    other = planner_for("anymal", "srbm", "ipopt").plan(jump)
    plan = solved("srbm", "twist").plan
    assert other.report.solver == "ipopt"
    assert other.report.cost == pytest.approx(plan.report.cost, rel=5e-3)
    np.testing.assert_allclose(other.com, plan.com, atol=0.01)


class Reluctant:
    """A backend whose first solves end where they began."""

    def __init__(self, backend, failures):
        self.backend, self.failures, self.calls, self.seconds = backend, failures, [], []
        self.name = backend.name

    def solve(self, guess, parameters, bounds, warm):
        self.calls.append((guess, warm))
        iterate = self.backend.solve(guess, parameters, bounds, warm)
        self.seconds.append(iterate.solve_time_s)
        if len(self.calls) <= self.failures:
            iterate = replace(iterate, w=guess, converged=False, message="reluctant")
        return iterate


@pytest.mark.parametrize(
    ("failures", "attempts", "solves", "label"),
    [
        (0, 1, 1, "from the analytic guess"),
        (1, 2, 2, "from a longer flight"),
        (2, 3, 5, "by way of easier jumps"),
    ],
)
def test_further_attempts_when_one_fails(planner, failures, attempts, solves, label):
    planner._backend = backend = Reluctant(planner._backend, failures)
    said = []
    plan = planner.plan(Jump(model="srbm", forward=0.3), progress=said.append)
    assert plan.solved
    assert plan.report.attempts == attempts
    assert len(backend.calls) == solves
    assert len(said) == attempts
    assert plan.report.solve_time_s == pytest.approx(sum(backend.seconds), rel=0.05)
    assert label in said[-1]
    assert plan.report.cost == pytest.approx(solved("srbm", "forward").plan.report.cost, rel=5e-3)
    if failures:
        first_in_flight = planner.layout.variables(planner.layout.intervals.takeoff)
        guess, warm = backend.calls[1]
        assert guess[first_in_flight["duration"]] == PATIENT_FLIGHT
        assert not warm


def test_what_cannot_be_says_what_is_violated(planner):
    """Legs that can barely carry the robot."""
    limits = ROBOT.file.limits.model_copy(update={"contact_force": 80.0})
    planner.robot = replace(ROBOT, file=ROBOT.file.model_copy(update={"limits": limits}))
    with pytest.raises(NotConverged) as caught:
        planner.plan(Jump(model="srbm", forward=0.5))
    message, plan = str(caught.value), caught.value.plan
    assert "\n" not in message
    assert message.startswith(
        "no plan found in 3 attempts (twist 0 deg, forward 0.5 m, lateral 0 m, height 0 m, srbm); "
    )
    name, v = max(plan.violations.items(), key=lambda item: excess(dict([item])))
    assert v.amount > TOLERANCE
    assert (
        f"{name} is violated by {v.amount:.3g} {v.unit} in {v.phase} at {v.time:.2f} s" in message
    )
    assert not plan.solved
    assert plan.report.status == "not-converged"
    assert plan.report.attempts == 3
    assert plan.com.shape == (INTERVALS + 1, 3)
    with pytest.raises(InputError, match="no solution yet"):
        planner.last_knots()


def test_cancelled(planner):
    planner._backend = Reluctant(planner._backend, 9)
    asked = []

    def after_the_first():
        asked.append(True)
        return len(asked) > 1

    with pytest.raises(Cancelled, match="planning was cancelled"):
        planner.plan(Jump(model="srbm", forward=0.3), cancelled=after_the_first)
    assert len(asked) == 2
    with pytest.raises(Cancelled):
        planner.plan(Jump(model="srbm", forward=0.3), cancelled=lambda: True)


def test_fewer_intervals():
    plan = Planner(ROBOT, "srbm", intervals=12).plan(Jump(model="srbm", twist=1.0))
    assert plan.solved
    assert len(plan.time) == 13


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("srmb",), "unknown model 'srmb'; the models are srbm, llsrbm, llsrbm-plus"),
        (("srbm", "snopt"), "unknown solver 'snopt'; the solvers are fatrop, ipopt"),
        (("srbm", "fatrop", 6), "intervals: 6 given; expected 9 to 300"),
        (("srbm", "fatrop", 301), "intervals: 301 given; expected 9 to 300"),
    ],
)
def test_what_it_cannot_be_made_of(arguments, message):
    with pytest.raises(InputError) as caught:
        Planner(ROBOT, *arguments)
    assert str(caught.value) == message


def test_solvers_by_name():
    assert solvers.names() == ("fatrop", "ipopt")
    assert [solvers.backend(name).name for name in solvers.names()] == list(solvers.names())


# ---- llsrbm.plan


def test_from_the_outside():
    plan = llsrbm.plan(Jump(model="srbm", **REQUESTS["all"]))
    np.testing.assert_array_equal(plan.com, solved("srbm", "all").plan.com)
    assert plan.report.build_time_s < 0.1  # it was at hand
    assert planner_for("anymal", "srbm") is planner_for("anymal", "srbm", "fatrop", INTERVALS)


@pytest.mark.parametrize(
    ("request_", "options", "message"),
    [
        ({"robot": "anymel"}, {}, 'no robot "anymel"'),
        ({"model": "rbm"}, {}, "unknown model 'rbm'"),
        ({"forward": 9.0}, {}, "forward 9 m is out of range"),
        ({}, {"solver": "snopt"}, "unknown solver 'snopt'"),
        ({}, {"weights": {"fun": 1.0}}, "unknown weight 'fun'"),
    ],
)
def test_bad_input(request_, options, message):
    with pytest.raises(InputError, match=message):
        llsrbm.plan(Jump(**request_), **options)
