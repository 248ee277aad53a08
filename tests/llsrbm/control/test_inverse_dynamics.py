from unittest.mock import patch

import numpy as np
import pytest

from llsrbm.control import tasks
from llsrbm.control.inverse_dynamics import InverseDynamics
from llsrbm.control.qp import Qp
from llsrbm.control.whole_body import WholeBody
from llsrbm.robots import load_robot
from tests.llsrbm.control.bodies import resting_target

FRICTION, WEIGHT, TICK = 0.6, 30.475 * 9.81, 0.0025
STANDING = np.ones(4, dtype=bool)
WIDE = (np.full(12, -200.0), np.full(12, 200.0))


def standing() -> WholeBody:
    robot = load_robot("anymal")
    body = WholeBody(robot)
    body.update(robot.posture, np.zeros(robot.model.nv))
    return body


def feet():
    return [(tasks.StandingFeet(range(4), 1, 0.0), 1e4)]


def solve(
    body,
    wishes,
    contact=STANDING,
    force=None,
    force_weight=1e-4,
    limits=WIDE,
    target=None,
    **beside,
):
    dynamics = InverseDynamics(body, FRICTION, "quadprog", TICK)
    command = dynamics.solve(
        wishes,
        target or resting_target(),
        contact,
        np.zeros((4, 3)) if force is None else force,
        force_weight,
        limits,
        **beside,
    )
    assert command.solved
    return command


def residual(body, command):
    """Of the whole equation of motion, with the torques that were returned."""
    actuated = np.concatenate([np.zeros(6), command.torque])
    pushed = np.einsum("lin,li->n", body.contact_jacobian, command.force)
    return body.M @ command.acceleration + body.h - actuated - pushed


def still(body):
    """Accelerate nothing: neither the CoM nor the attitude."""
    target = resting_target()
    return [
        (tasks.CentreOfMass((0.0, 0.0)), 10.0),
        (tasks.BaseOrientation((0.0, 0.0)), 10.0),
    ], target


def test_stands_by_carrying_its_weight():
    body = standing()
    wishes, target = still(body)
    carried = np.tile([0.0, 0.0, WEIGHT / 4], (4, 1))
    command = solve(body, [*wishes, *feet()], force=carried, target=target)
    np.testing.assert_allclose(command.force.sum(axis=0), [0, 0, WEIGHT], atol=0.5)
    assert np.abs(command.acceleration).max() < 0.05
    np.testing.assert_allclose(residual(body, command), 0.0, atol=1e-6)


def test_forces_stay_in_the_friction_pyramid():
    body = standing()
    sideways = np.tile([500.0, -400.0, 80.0], (4, 1))
    command = solve(body, feet(), force=sideways, force_weight=1.0)
    horizontal = np.abs(command.force[:, :2]).max(axis=1)
    assert (horizontal <= FRICTION * command.force[:, 2] + 1e-6).all()
    assert horizontal.max() > 10.0


def test_torques_stay_within_what_the_drives_give():
    body = standing()
    limits = (np.full(12, -7.0), np.full(12, 5.0))
    wishes, target = still(body)
    command = solve(body, [*wishes, *feet()], limits=limits, target=target)
    assert command.torque.max() <= 5.0 + 1e-6
    assert command.torque.min() >= -7.0 - 1e-6
    assert max(command.torque.max() / 5.0, -command.torque.min() / 7.0) == pytest.approx(1.0)


def test_friction_is_given_beside_what_moves_the_robot():
    body, friction = standing(), np.linspace(-3, 3, 12)
    wishes, target = still(body)
    free = solve(body, [*wishes, *feet()], target=target)
    command = solve(body, [*wishes, *feet()], target=target, friction=friction)
    np.testing.assert_allclose(command.acceleration, free.acceleration, atol=1e-9)
    np.testing.assert_allclose(command.torque, free.torque + friction, atol=1e-9)


def test_friction_is_within_what_the_drives_give():
    body, friction = standing(), np.full(12, 3.0)
    limits = (np.full(12, -6.0), np.full(12, 8.0))
    wishes, target = still(body)
    command = solve(body, [*wishes, *feet()], limits=limits, target=target, friction=friction)
    assert command.torque.min() >= -6.0 - 1e-6
    assert command.torque.max() <= 8.0 + 1e-6
    assert max(command.torque.max() / 8.0, -command.torque.min() / 6.0) == pytest.approx(1.0)
    left = command._replace(torque=command.torque - friction)
    np.testing.assert_allclose(residual(body, left), 0.0, atol=1e-6)


def test_what_comes_beside_is_left_out_of_what_is_asked_for():
    """Torques are for so much less; what is expected is what was wanted."""
    body = standing()
    wishes, target = still(body)
    # Of the trunk by itself: feet that stand are held by the ground, and leave nothing out.
    unmodelled = np.concatenate([[0.3, -0.2, 0.5, 0.4, -0.3, 0.2], np.zeros(12)])
    in_the_air = {"contact": np.zeros(4, dtype=bool), "target": target}
    wishes = [(tasks.BaseOrientation((0.0, 0.0)), 1e4)]
    command = solve(body, wishes, **in_the_air, unmodelled=unmodelled)
    np.testing.assert_allclose(command.acceleration[3:6], 0.0, atol=1e-3)
    asked = command._replace(acceleration=command.acceleration - unmodelled)
    np.testing.assert_allclose(residual(body, asked), 0.0, atol=1e-6)


def test_feet_that_stand_leave_nothing_out():
    body, unmodelled = standing(), np.full(18, 0.4)
    command = solve(body, feet(), unmodelled=unmodelled)
    asked = command.acceleration - unmodelled
    accelerated = np.einsum("lin,n->li", body.contact_jacobian, asked)
    np.testing.assert_allclose(accelerated, 0.0, atol=1e-3)


def test_a_foot_in_the_air_does_not_push():
    body = standing()
    contact = np.array([True, False, True, True])
    wishes, target = still(body)
    command = solve(body, [*wishes, *feet()], contact=contact, target=target)
    assert not command.force[1].any()


class Failing:
    """`dynamics.solve` of a standing robot, unsolvable on request."""

    def __init__(self, tick: float = TICK) -> None:
        self.body = standing()
        self.dynamics = InverseDynamics(self.body, FRICTION, "quadprog", tick)

    def __call__(self, *, fails: bool, limits=WIDE):
        wishes, target = still(self.body)
        problem = [*wishes, *feet()], target, STANDING, np.zeros((4, 3)), 1e-4, limits
        solve = (lambda _: None) if fails else Qp.solve
        with patch.object(Qp, "solve", solve):
            return self.dynamics.solve(*problem)

    def move(self, speed):
        """Let all joints move, rad/s."""
        self.body.update(self.body.q, np.concatenate([np.zeros(6), np.full(12, speed)]))


@pytest.mark.parametrize("tick", [0.0025, 0.001])
def test_torques_are_held_for_ten_milliseconds(tick):
    solve = Failing(tick)
    good = solve(fails=False)
    for _ in range(round(0.010 / tick)):
        command = solve(fails=True)
        assert not command.solved
        np.testing.assert_array_equal(command.torque, good.torque)
    assert not np.array_equal(solve(fails=True).torque, good.torque)


def test_held_torques_stay_within_the_drives():
    solve = Failing()
    solve(fails=False)
    low, high = np.full(12, -3.0), np.full(12, 2.0)
    torque = solve(fails=True, limits=(low, high)).torque
    assert (torque.min(), torque.max()) == (-3.0, 2.0)


def test_then_joints_are_damped():
    solve = Failing()
    solve(fails=False)
    solve.move(2.0)
    for _ in range(5):
        command = solve(fails=True)
    assert (command.torque < 0).all()
    assert not command.force.any()
    # Joint by joint, the others held: speed is lost within 50 ms.
    inertia = np.diag(solve.body.M)[6:]
    np.testing.assert_allclose(command.torque / inertia, -2.0 / 0.05)
    low, high = np.full(12, -0.1), np.full(12, 0.1)
    np.testing.assert_array_equal(solve(fails=True, limits=(low, high)).torque, low)


def test_a_solution_ends_the_damping():
    solve = Failing()
    good = solve(fails=False)
    for _ in range(9):
        solve(fails=True)
    np.testing.assert_allclose(solve(fails=False).torque, good.torque)
    np.testing.assert_allclose(solve(fails=True).torque, good.torque)  # and is held again
