import numpy as np
import pytest

from llsrbm import models
from llsrbm.jump import Jump
from llsrbm.planning.guess import analytic_guess
from llsrbm.planning.knots import unpack
from llsrbm.planning.layout import Layout
from llsrbm.planning.placement import make_task
from llsrbm.planning.residuals import violations
from llsrbm.robots import load_robot

ROBOT = load_robot("anymal")
LAYOUT = Layout(4, ((True,) * 4, (False,) * 4, (True,) * 4), (16, 16, 16))
CORNERS = [
    {"twist": np.pi},
    {"twist": -np.pi, "forward": 0.6},
    {"forward": -0.3, "lateral": 0.3, "height": -0.2},
    {"twist": 1.0, "forward": 0.6, "lateral": -0.3, "height": 0.3},
    {},
]


@pytest.mark.parametrize("model", models.names())
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
    # What is cheap to satisfy from the start is satisfied.
    found = violations(knots)
    for name in ("phase_times", "friction_pyramid"):
        assert found[name].amount < 1e-9, name
    assert found["final_state"].amount < 1e-9


def test_flight_is_ballistic_and_continuous():
    task = make_task(Jump(twist=1.0, forward=0.4, height=0.2), ROBOT)
    made = models.make_model("srbm", ROBOT)
    knots = unpack(analytic_guess(task, LAYOUT, made), LAYOUT, task, made)
    flying = np.flatnonzero(knots.phase == 1)
    dt = knots.dt[flying]
    fall = np.diff(knots.velocity[flying[0] : flying[-1] + 2], axis=0) / dt[:, None]
    np.testing.assert_allclose(fall, np.tile([0, 0, -9.81], (len(dt), 1)), atol=1e-9)
    steps = np.linalg.norm(np.diff(knots.position, axis=0), axis=1)
    fastest = np.linalg.norm(knots.velocity, axis=1).max()
    assert (steps <= 1.5 * fastest * knots.dt + 1e-9).all()


@pytest.mark.parametrize(("asked", "given"), [(0.45, 0.45), (0.1, 0.3), (5.0, 0.6)])
def test_flight_time_as_asked_within_the_robots_range(asked, given):
    task = make_task(Jump(), ROBOT)
    made = models.make_model("srbm", ROBOT)
    knots = unpack(analytic_guess(task, LAYOUT, made, asked), LAYOUT, task, made)
    assert knots.durations[1] == pytest.approx(given)
