import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from llsrbm import models
from llsrbm.planning.problem.knots import unpack
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.solve.guess import analytic_guess
from llsrbm.planning.solve.jump_layout import layout_of
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.llsrbm.planning.any_schedule import task_of
from tests.llsrbm.planning.solved import TYPES, variable
from tests.llsrbm.schedules import schedules

ROBOT = load_robot("anymal")
LAYOUT = Layout(4, ((True,) * 4, (False,) * 4, (True,) * 4), (16, 16, 16))
CORNERS = [
    {"twist": np.pi},
    {"twist": -np.pi, "forward": 0.6},
    {"forward": -0.3, "lateral": 0.3, "height": -0.2},
    {"twist": 1.0, "forward": 0.6, "lateral": -0.3, "height": 0.3},
    {},
]


@pytest.mark.parametrize("model", models.MODELS)
@pytest.mark.parametrize("request_", CORNERS, ids=str)
def test_a_hop_from_start_to_goal(model, request_):
    task = make_task(Jump(**request_), ROBOT)
    made = models.make_model(model, ROBOT)
    w = analytic_guess(task, LAYOUT, made)
    assert w.shape == (LAYOUT.size_total,)
    assert np.isfinite(w).all()
    knots = unpack(w, LAYOUT, task, made)
    np.testing.assert_allclose(knots.position[0], task.start_position)
    np.testing.assert_allclose(knots.position[-1], task.goal_position, atol=1e-12)
    np.testing.assert_allclose(knots.quat[-1], task.goal_quat, atol=1e-12)
    np.testing.assert_allclose(knots.velocity[-1], 0, atol=1e-12)
    for p, taken in enumerate(knots.durations):
        assert task.times(p)[0] <= taken <= task.times(p)[1]
    assert not knots.force[..., :2].any()


# ---- any schedule

MODEL = models.make_model("llsrbm-plus", ROBOT)


@st.composite
def guesses(draw):
    """Task, layout and guessed variables."""
    schedule = draw(schedules(tuple(leg.name for leg in ROBOT.legs)))
    shift = [draw(st.floats(*bounds)) for bounds in ((-0.1, 0.2), (-0.1, 0.1), (-0.1, 0.1))]
    task = task_of(schedule, ROBOT, shift, draw(st.floats(-0.5, 0.5)))
    layout = Layout.of(schedule, 4, draw(st.integers(9, 48)), 3)
    return task, layout, analytic_guess(task, layout, MODEL)


@settings(max_examples=10, deadline=None)
@given(guesses())
def test_any_schedules_guess_is_a_motion_from_start_to_goal(made):
    task, layout, w = made
    assert w.shape == (layout.size_total,)
    assert np.isfinite(w).all()
    knots = unpack(w, layout, task, MODEL)
    assert (np.diff(knots.time) > 0).all()
    np.testing.assert_allclose(knots.position[[0, -1]], [task.start_position, task.goal_position])
    np.testing.assert_allclose(knots.quat[-1], task.goal_quat, atol=1e-9)
    np.testing.assert_allclose(knots.velocity[[0, -1]], 0.0, atol=1e-9)
    for p, taken in enumerate(knots.durations):
        low, high = task.times(p)
        assert low - 1e-9 <= taken <= high + 1e-9
    # Legs have a length they can have, and feet go on from knot to knot.
    shortest, longest = task.reach.distance
    for leg, lift, touch in layout.swings:
        length = np.linalg.norm(knots.feet_in_hip[lift : touch + 1, leg], axis=1)
        assert shortest - 1e-9 <= length[1:-1].min() <= length[1:-1].max() <= longest + 1e-9
        for k in range(lift, touch):
            rate = sum(variable(knots, name, k, leg) for name in ("feet_velocity", "feet_step"))
            moved = knots.feet_in_hip[k + 1, leg] - knots.feet_in_hip[k, leg]
            np.testing.assert_allclose(moved, rate * knots.dt[k], atol=1e-9)
    # In flight the CoM falls freely; a step is as long as the speeds at its ends say, but for what
    # the acceleration changes over it.
    for flight in knots.flights:
        fall = np.diff(knots.velocity[flight.start : flight.stop + 1], axis=0)
        np.testing.assert_allclose(fall, knots.dt[flight, None] * [0, 0, -9.81], atol=1e-9)
    steps = np.linalg.norm(np.diff(knots.position, axis=0), axis=1)
    mean = (knots.velocity[1:] + knots.velocity[:-1]) / 2
    off = np.abs(steps - np.linalg.norm(mean, axis=1) * knots.dt)
    assert (off < 2.0 * knots.dt**2).all()
    # Variables are where they belong.
    unit = task.mass * 9.81 / 4
    for k, role in enumerate(layout.roles[1:-1], start=1):
        np.testing.assert_allclose(knots.momentum[k], variable(knots, "momentum", k) * task.mass)
        np.testing.assert_allclose(knots.rotation_rate[k], variable(knots, "rotation_rate", k))
        for leg in range(layout.legs):
            stands = leg in role.standing
            force = variable(knots, "force", k, leg) * unit if stands else np.zeros(3)
            np.testing.assert_allclose(knots.force[k, leg], force, atol=1e-12)


def seen(knots, k):
    """(L, 3) m: the feet as the model places them."""
    x = knots.feet_in_hip[k]
    offset = np.array(MODEL.base_offset(ca.DM(x.T))).ravel()
    R = Rotation.from_quat(knots.quat[k], scalar_first=True)
    return knots.position[k] + R.apply(offset + MODEL.hips + MODEL.mirrors * x)


@pytest.mark.parametrize("name", TYPES)
def test_feet_swing_from_where_they_stood_to_where_they_will_stand(name):
    jump = Jump(**TYPES[name])
    task, layout = make_task(jump, ROBOT), layout_of(jump, ROBOT)
    knots = unpack(analytic_guess(task, layout, MODEL), layout, task, MODEL)
    for leg, lift, touch in layout.swings:
        stood, lands = (task.footholds_before(layout.phase[k]).feet[leg] for k in (lift - 1, touch))
        assert np.linalg.norm(seen(knots, lift)[leg] - stood) < 0.1
        assert np.linalg.norm(seen(knots, touch)[leg] - lands) < 0.1


@pytest.mark.parametrize("turn", [{"pitch": -2 * np.pi}, {"pitch": 2 * np.pi}, {"roll": 2 * np.pi}])
def test_a_flip_turns_over_in_flight(turn):
    """Attitudes turn by the angle that is asked, whole turns among it."""
    robot = load_robot("go2")
    jump = Jump(robot="go2", type="barrel-roll" if "roll" in turn else "flip", **turn)
    task, layout = make_task(jump, robot), layout_of(jump, robot)
    made = models.make_model("llsrbm-plus", robot)
    knots = unpack(analytic_guess(task, layout, made), layout, task, made)
    np.testing.assert_allclose(knots.quat[-1], task.goal_quat, atol=1e-9)
    axis = 1 if jump.pitch else 0
    turned = knots.rotation_rate * knots.dt[:, None]
    assert turned[:, axis].sum() == pytest.approx(jump.pitch + jump.roll, rel=0.02)
    np.testing.assert_allclose(np.delete(turned, axis, axis=1), 0.0, atol=1e-9)
    (flight,) = knots.flights
    assert turned[flight, axis].sum() == pytest.approx(0.8 * (jump.pitch + jump.roll), rel=0.02)
    # The quaternion runs through the turn without a jump.
    assert (np.sum(knots.quat[1:] * knots.quat[:-1], axis=1) > 0.9).all()


def test_mirrored_requests_have_mirrored_guesses():
    robot, mirror, other = load_robot("go2"), [1.0, -1.0, 1.0], [1, 0, 3, 2]
    made = models.make_model("llsrbm-plus", robot)
    guessed = []
    for roll in (2 * np.pi, -2 * np.pi):
        jump = Jump(robot="go2", type="barrel-roll", roll=roll)
        task, layout = make_task(jump, robot), layout_of(jump, robot)
        guessed.append(unpack(analytic_guess(task, layout, made), layout, task, made))
    right, left = guessed
    np.testing.assert_allclose(left.position * mirror, right.position, atol=1e-9)
    np.testing.assert_allclose(left.quat * [1, -1, 1, -1], right.quat, atol=1e-9)
    np.testing.assert_allclose(left.feet_in_hip[:, other], right.feet_in_hip, atol=1e-5)


def test_a_run_up_starts_and_ends_with_speed():
    jump = Jump(type="run-up", speed=0.6, end_speed=0.3, forward=0.4, twist=0.5)
    task, layout = make_task(jump, ROBOT), layout_of(jump, ROBOT)
    knots = unpack(analytic_guess(task, layout, MODEL), layout, task, MODEL)
    np.testing.assert_allclose(knots.velocity[0], [0.6, 0, 0], atol=1e-12)
    end = 0.3 * np.array([np.cos(0.5), np.sin(0.5), 0.0])
    np.testing.assert_allclose(knots.velocity[-1], end, atol=1e-9)
