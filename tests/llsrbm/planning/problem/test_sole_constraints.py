"""SLIDER's plans: what soles add, looked at in NumPy, and broken by known amounts."""

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from llsrbm.mechanics import yaw
from llsrbm.planning.problem.costs import COSTS
from llsrbm.planning.problem.foot_clearance import APART, ROOM, edge_range
from llsrbm.planning.problem.placement import place_task
from llsrbm.planning.problem.rotations import (
    across,
    direction,
    heading_rate,
    relative_yaw,
    relative_yaw_rate,
)
from llsrbm.planning.problem.violations import violations
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.llsrbm.planning.solved import changed, solved, variable

ROBOT = load_robot("slider")
FOOT, LIMITS = ROBOT.file.foot, ROBOT.file.limits
LIFT_OFF, LEG = 16, 1
MIDDLE = LIFT_OFF + 8


@pytest.fixture(scope="module")
def twist():
    return solved("llsrbm-plus", "twist", "slider")


@pytest.fixture(scope="module")
def box():
    return solved("llsrbm-plus", "box", "slider")


def test_foot_yaw(twist):
    foot = variable(twist.knots, "feet", MIDDLE, LEG)
    foot[3] = FOOT.yaw[1] + 0.05
    broken = changed(twist.knots, ("feet", MIDDLE, LEG, foot))
    found = violations(broken)["foot_yaw"]
    assert found.amount == pytest.approx(0.05, abs=1e-6)
    assert found.phase == "flight"


def test_foot_turn(twist):
    step = variable(twist.knots, "feet_step", MIDDLE, LEG)
    step[3] = FOOT.turn_speed + 2.0 - variable(twist.knots, "feet_velocity", MIDDLE, LEG)[3]
    broken = changed(twist.knots, ("feet_step", MIDDLE, LEG, step))
    assert violations(broken)["foot_turn"].amount >= 2.0


def test_edge(box):
    """Toes that swing 0.1 m forward at once run into the box."""
    foot = variable(box.knots, "feet", LIFT_OFF + 2, LEG)
    foot[0] += 0.1
    broken = changed(box.knots, ("feet", LIFT_OFF + 2, LEG, foot))
    assert violations(broken)["edge"].amount == pytest.approx(0.1, abs=0.03)


@pytest.mark.parametrize("name", ["slider", "g1", "go2"])
def test_below_a_box_feet_keep_as_far_from_the_middle_of_their_way_as_balls_do(name):
    robot = load_robot(name)
    task = place_task(Jump(robot=name, forward=0.45, height=0.1), robot)
    low, high = edge_range(task, 1, np.full((1, len(robot.legs)), 0.1), np.full((1, 1), 0.05))
    toes = task.places[0].contacts[:, 0].reshape(len(robot.legs), -1).max(axis=1)
    heels = task.places[1].contacts[:, 0].min()
    assert high[0] == pytest.approx(np.maximum((toes + heels) / 2 - APART, toes + ROOM))
    assert (low < -1.0).all()  # nothing to mind from behind


def test_edges_of_a_box_that_is_turned_lie_ahead_of_each_foot():
    """Landing turned by 45 degrees, the box lies to the right of one foot, before the other."""
    jump = Jump(robot="slider", twist=np.pi / 4, forward=0.3, height=0.35)
    task = place_task(jump, ROBOT)
    start, goal = task.places
    ahead = np.array([np.cos(np.pi / 4), np.sin(np.pi / 4)])
    right = np.array([ahead[1], -ahead[0]])
    np.testing.assert_allclose(task.towards(1), [right, ahead], atol=1e-12)
    for towards, foot in zip(task.towards(1), start.contacts.reshape(2, 4, 3), strict=True):
        assert (foot[:, :2] @ towards).max() < (goal.contacts[:, :2] @ towards).min()
    on_the_spot = place_task(Jump(robot="slider", height=0.2), ROBOT)
    assert not on_the_spot.towards(1).any()


@pytest.mark.parametrize("seed", range(5))
def test_headings_and_yaws(seed):
    """There and back, and rates against differences, at random attitudes."""
    rng = np.random.default_rng(seed)
    R = Rotation.from_euler("zyx", rng.uniform([-3, -0.5, -0.5], [3, 0.5, 0.5]))
    heading = R.as_euler("zyx")[0] + rng.uniform(-1.1, 1.1)
    omega, spin, h = rng.normal(size=3), rng.normal(), 1e-6

    def phi(t):
        turned = R * Rotation.from_rotvec(t * omega)
        return float(relative_yaw(across(ca.DM(turned.as_matrix()), heading)))

    def psi(t):
        turned = R * Rotation.from_rotvec(t * omega)
        x, y = np.array(direction(ca.DM(turned.as_matrix()), phi(0) + t * spin)).ravel()
        return np.arctan2(y, x)

    assert np.cos(psi(0) - heading) == pytest.approx(1.0)
    rate = relative_yaw_rate(across(ca.DM(R.as_matrix()), heading), ca.DM(omega))
    assert float(rate) == pytest.approx((phi(h) - phi(-h)) / (2 * h), abs=1e-6)
    turning = heading_rate(ca.DM(R.as_matrix()[2]), phi(0), spin, ca.DM(omega))
    assert float(turning) == pytest.approx((psi(h) - psi(-h)) / (2 * h), abs=1e-6)


def test_symmetry_fades_with_the_twist():
    (symmetry,) = (cost for cost in COSTS if cost.name == "symmetry")
    assert symmetry.share(Jump()) == 1.0
    assert symmetry.share(Jump(twist=0.2)) == pytest.approx(0.5)


def test_contact_points_are_the_corners_of_the_soles(twist):
    plan = twist.plan
    assert plan.contact_point.shape == (len(plan.time), 8, 3)
    for i in range(2):
        heading = yaw(plan.foot_quat[:, i])
        c, s = np.cos(heading)[:, None], np.sin(heading)[:, None]
        x, y = np.array(FOOT.corners).T
        expected = plan.foot_position[:, i, None, :2] + np.stack(
            [c * x - s * y, s * x + c * y], axis=-1
        )
        np.testing.assert_allclose(
            plan.contact_point[:, 4 * i : 4 * i + 4, :2], expected, atol=1e-4
        )


def test_corners_push_within_their_pyramids(twist, box):
    for solution in (twist, box):
        force = solution.plan.contact_force
        assert force[..., 2].min() > -1e-3
        sideways = np.abs(force[..., :2]) - LIMITS.friction / np.sqrt(2) * force[..., 2:]
        assert sideways.max() < 1e-3


@pytest.mark.parametrize("request_name", ["twist", "box"])
def test_momenta_follow_from_the_corners_forces(request_name):
    """Forces are constant over an interval, so that both integrals have closed forms."""
    plan = solved("llsrbm-plus", request_name, "slider").plan
    dt = np.diff(plan.time)[:, None]
    force = plan.contact_force[:-1]
    total = force.sum(axis=1)
    acceleration = total / ROBOT.mass + [0.0, 0.0, -9.81]
    mean_com = plan.com[:-1] + plan.com_velocity[:-1] * dt / 2 + acceleration * dt**2 / 6
    moment = np.cross(plan.contact_point[:-1] - mean_com[:, None], force).sum(axis=1)
    np.testing.assert_allclose(np.diff(plan.com_velocity, axis=0), acceleration * dt, atol=1e-6)
    np.testing.assert_allclose(np.diff(plan.angular_momentum, axis=0), moment * dt, atol=1e-5)
